"""Files for other programs: areas of the glottis in; flow, pressures and positions of the folds out."""
