#pragma once
#include <functional>
#include <string>

#include "plica/solve/supports.hpp"
#include "plica/tissue/assembly.hpp"

namespace plica {

/// A way through states of rest of tissue at finite strain: from share 0, where nothing is displaced, to share 1,
/// which is sought. Equations at a share: balance(u).force = 0 where nothing is held.
struct StaticWay {
  /// The force (3 n) N that is out of balance at a displacement (3 n) m, and its slope. Throws CellInverted.
  std::function<Assembler::Stretched(const Vector& u, double share)> balance;
  /// (3 n) m: by how much what is held moves between two shares, 0 elsewhere.
  std::function<Vector(double from, double to)> moved;
  std::string name;  // of an error: "Posture"
  std::string of;    // share of what: "it"
  std::string hint;  // "Take less of it."
};

/// Where a way ends.
struct StaticEnd {
  Vector displacement;  // (3 n) m
  int parts = 0;        // of the way, that were taken one by one
  int iterations = 0;   // of Newton's method in all
};

/// Goes the way in parts, halved where they do not lead on: Newton's method with its exact slope, which has to be
/// positive definite wherever it is looked at, to a step below 1e-11 of the mesh's size. A part is taken if its
/// motion is that of the trapezoidal rule to a quarter of it: tissue that snaps through ends elsewhere. Throws
/// SolveFailed naming the share at which a cell is inverted or the tissue gives way (buckles).
StaticEnd walk(const TetMesh& mesh, const Supports& supports, const StaticWay& way);

}  // namespace plica
