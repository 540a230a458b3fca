#include "plica/contact/node_pairs.hpp"

namespace plica {

namespace {

class NodePairs : public ConstraintKind {
 public:
  explicit NodePairs(Detector& detector) : detector_(detector) {}

  void update(const Points&) override {}  // the detector itself is up to date

  std::vector<std::int32_t> violated(const Points& x, double reach, const ContactSurface& side,
                                     double least) override {
    std::vector<std::int32_t> found;
    for (const Pair& pair : detector_.inside(side, x, reach))
      if (pair.gap(x) < -least) found.push_back(pair.slave);
    return found;
  }

  bool knows(std::int32_t node) const override { return detector_.contains(node); }

  Constraint at(std::int32_t slave, const Points& x, double) override {
    return detector_.pair(slave, x).constraint();
  }

  std::vector<PressedNode> pressed(const ContactSurface& side, const Contact& contact, const Points& x) override {
    std::vector<PressedNode> found;
    for (const std::int32_t node : side.nodes()) {
      const double force = contact.nodal_force.segment<3>(3 * node).norm(), area = side.tributary_area(node);
      if (force > 0) found.push_back({node, area, force / area, side.tributary_stretch(node, x)});
    }
    return found;
  }

  Vector pressure(const Contact& contact, const Points& x) override {
    Vector pressure = Vector::Zero(x.rows());
    for (const ContactSurface* side : {&detector_.first(), &detector_.second()})
      for (const PressedNode& node : pressed(*side, contact, x)) pressure[node.node] = node.pressure;
    return pressure;
  }

 protected:
  Detector& detector_;
};

class VolumePairs final : public NodePairs {
 public:
  VolumePairs(Detector& detector, double kappa) : NodePairs(detector), kappa_(kappa) {}

  std::vector<std::int32_t> violated(const Points& x, double reach, const ContactSurface&, double) override {
    std::vector<std::int32_t> found;
    for (const std::int32_t tet : detector_.inverted_tets()) {
      const Pair by_volume = detector_.volume_pair(tet, x, 1.0);
      if (by_volume.key >= 0 && detector_.pair(by_volume.slave, x).penetrates(x, reach)) found.push_back(tet);
    }
    return found;
  }

  bool knows(std::int32_t tet) const override {
    const Airway& airway = detector_.airway();
    return tet >= 0 && (airway.renewed || tet < airway.tets.rows());
  }

  Constraint at(std::int32_t tet, const Points& x, double) override {
    return detector_.volume_pair(tet, x, kappa_).constraint();
  }

 private:
  double kappa_;
};

}  // namespace

std::unique_ptr<ConstraintKind> node_pairs(Detector& detector) { return std::make_unique<NodePairs>(detector); }

std::unique_ptr<ConstraintKind> volume_pairs(Detector& detector, double kappa) {
  return std::make_unique<VolumePairs>(detector, kappa);
}

}  // namespace plica
