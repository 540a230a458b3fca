"""Laws of tissue: constant strains, rigid motion, moduli, creep, natural frequencies."""
