#pragma once
// Where lines of sight meet the faces of a surface, flat or curved.
#include "plica/imaging/raster.hpp"

namespace plica::imaging {

/// Places of lines of sight in faces.
struct FaceHits {
  Indices face;  // (p), -1 where there is none
  Pairs place;   // (p, 2) coordinates (r, s) in it
};

/// The place in a given face that each line of sight shows, by Newton's iteration from a start.
/// nodes (n, 3) column px, row px, height; faces (f, 3) or (f, 6) rows of nodes, with six the middles of the sides
/// 12, 23, 31; face (p) a row of faces; pixels (p, 2) column and row; start (p, 2). A face is -1 and a place the
/// start where the iteration does not end inside the face, on a side that faces the camera.
FaceHits hits_near(const Points& nodes, const Faces& faces, const Indices& face, const Pairs& pixels,
                   const Pairs& start);

/// The nearest face that each line of sight meets from its outer side; a pixel with NaN meets none.
/// A curved face lies in the hull of its Bezier points, so that none is missed; within a face Newton's iteration
/// begins at fifteen places, at one in a flat face.
FaceHits first_hits(const Points& nodes, const Faces& faces, const Pairs& pixels);

}  // namespace plica::imaging
