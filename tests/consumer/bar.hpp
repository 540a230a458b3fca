#pragma once
#include <plica/mesh/tet_mesh.hpp>

/// A bar along x of length 2 cm and 1 cm x 1 cm across, its nodes and cells made here by hand: what an embedder
/// brings. Node sets "clamp" (x = 0) and "tip"; surface "side" (z = 1 cm).
plica::TetMesh make_bar(int along, int across);
