#include "plica/dynamics/reduced_collision.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <limits>

#include "plica/core/error.hpp"
#include "plica/dynamics/contact_record.hpp"

namespace plica {

namespace {

/// The displacement (3 m) of the contact's nodes in a step under forces on them, Phi A^-1 Phi^T f, in the place of
/// the inverse of a step matrix that has no other unknowns.
class InterfaceResponse final : public LinearSolver {
 public:
  InterfaceResponse(const Eigen::MatrixXd& shapes, const Eigen::MatrixXd& inverse)
      : root_(inverse.llt().matrixL().transpose() * shapes.transpose()) {}
  Convergence solve(const Vector& b, Guess& guess, double, const Product& product) const override {
    guess.x = root_.transpose() * (root_ * b);
    product(guess.x, guess.product);
    return {1, 0.0, true};
  }
  Convergence solve(const Vector& b, Guess& guess, double) const override {
    guess.x = root_.transpose() * (root_ * b);
    return {1, 0.0, true};
  }
  std::vector<Convergence> solve_many(const Eigen::MatrixXd& B, Eigen::MatrixXd& X, double) const override {
    X = root_.transpose() * (root_ * B);
    return std::vector<Convergence>(static_cast<std::size_t>(B.cols()), {1, 0.0, true});
  }
  std::string name() const override { return "reduced"; }
  double tolerance() const override { return KrylovOptions{}.tolerance; }

 private:
  Eigen::MatrixXd root_;  // (r, 3 m)
};

/// (n) m, to the nearest node of the other surface that shares an air tetrahedron; infinite for others.
std::vector<double> widths_of_air(const Airway& airway, const Points& x) {
  const auto marked = [&](const Triangles& side) {
    std::vector<char> mark(static_cast<std::size_t>(x.rows()), 0);
    for (const std::int32_t node : side.reshaped()) mark[static_cast<std::size_t>(node)] = 1;
    return mark;
  };
  const std::vector<char> first = marked(airway.first), second = marked(airway.second);
  std::vector<double> width(static_cast<std::size_t>(x.rows()), std::numeric_limits<double>::infinity());
  for (const auto& tet : airway.tets.rowwise())
    for (const std::int32_t a : tet)
      for (const std::int32_t b : tet) {
        const auto i = static_cast<std::size_t>(a), j = static_cast<std::size_t>(b);
        if (first[i] && second[j]) {
          const double apart = (x.row(a) - x.row(b)).norm();
          width[i] = std::min(width[i], apart);
          width[j] = std::min(width[j], apart);
        }
      }
  return width;
}

/// Those rows whose nodes are all kept, in the numbers of `local`.
template <typename Rows>
Rows kept_rows(const Rows& rows, const std::vector<std::int32_t>& local) {
  std::vector<std::ptrdiff_t> whole;
  for (std::ptrdiff_t i = 0; i < rows.rows(); ++i)
    if ((rows.row(i).array().unaryExpr([&](std::int32_t node) { return local[node]; }) >= 0).all())
      whole.push_back(i);
  Rows kept = rows(whole, Eigen::all);
  for (std::int32_t& node : kept.reshaped()) node = local[static_cast<std::size_t>(node)];
  return kept;
}

/// Those rows that kept_rows leaves out, in their own numbers.
Tets rows_beyond(const Tets& rows, const std::vector<std::int32_t>& local) {
  std::vector<std::ptrdiff_t> left;
  for (std::ptrdiff_t i = 0; i < rows.rows(); ++i)
    if ((rows.row(i).array().unaryExpr([&](std::int32_t node) { return local[node]; }) < 0).any())
      left.push_back(i);
  return rows(left, Eigen::all);
}

/// Node and the node that faces it on the other surface, by local numbers, those common to both left out; none
/// where the airway does not say along which direction they face each other.
std::vector<std::array<std::int32_t, 2>> facing_pairs(const Airway& airway, const Points& x) {
  std::vector<std::array<std::int32_t, 2>> pairs;
  if (airway.facing.isZero(0)) return pairs;
  std::vector<char> first(static_cast<std::size_t>(x.rows()), 0), second = first;
  for (const std::int32_t node : airway.first.reshaped()) first[static_cast<std::size_t>(node)] = 1;
  for (const std::int32_t node : airway.second.reshaped()) second[static_cast<std::size_t>(node)] = 1;
  std::vector<std::int32_t> partner(static_cast<std::size_t>(x.rows()), -1);
  const auto beside = [&](std::int32_t a, std::int32_t b) {
    const Vector3 apart = x.row(b) - x.row(a);
    return (apart - airway.facing.dot(apart) * airway.facing).norm();
  };
  for (const auto& tet : airway.tets.rowwise())
    for (const std::int32_t a : tet)
      for (const std::int32_t b : tet) {
        const auto i = static_cast<std::size_t>(a), j = static_cast<std::size_t>(b);
        if (!first[i] || second[i] || !second[j] || first[j]) continue;
        if (partner[i] < 0 || beside(a, b) < beside(a, partner[i])) partner[i] = b;
      }
  for (std::int32_t a = 0; a < x.rows(); ++a)
    if (partner[static_cast<std::size_t>(a)] >= 0) pairs.push_back({a, partner[static_cast<std::size_t>(a)]});
  return pairs;
}

void check(const ContactPart& part) {
  const auto refuse = [](const char* what) {
    throw InvalidInput(std::string("Reduction: ") + what + " Leave the reduction out, or choose another contact.");
  };
  if (part.airway.renewed) refuse("contact.airway = \"triangulated\"; must be \"matched\".");
  if (part.surface_mass != SurfaceMass::kept)
    refuse("contact.surface_mass = \"redistributed\"; must be \"kept\".");
  if (!std::holds_alternative<AtNodes>(part.faces)) refuse("contact.faces = \"mortar\"; must be \"nodes\".");
  if (std::holds_alternative<Nitsche>(part.enforcement))
    refuse("contact by Nitsche's method sees the whole tissue.");
}

}  // namespace

ReducedCollision::ReducedCollision(const Scene& scene, const Motion& full, const ModalMotion& motion)
    : motion_(motion), mesh_nodes_(scene.mesh.node_count()), held_(0) {
  const ContactPart& part = *scene.contact;
  check(part);
  // The nodes within reach and those around them, the faces of these and the air between.
  const std::vector<double> width = widths_of_air(part.airway, full.reference());
  const auto within = [&](std::int32_t node) {
    return width[static_cast<std::size_t>(node)] <= scene.reduction->contact_reach;
  };
  std::vector<std::int32_t> nodes;
  for (const Triangles* side : {&part.airway.first, &part.airway.second})
    for (const auto& face : side->rowwise())
      if (std::any_of(face.begin(), face.end(), within)) nodes.insert(nodes.end(), face.begin(), face.end());
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  std::vector<std::int32_t> local(static_cast<std::size_t>(mesh_nodes_), -1);
  for (std::size_t i = 0; i < nodes.size(); ++i)
    local[static_cast<std::size_t>(nodes[i])] = static_cast<std::int32_t>(i);
  nodes_ = Eigen::Map<Indices>(nodes.data(), static_cast<std::ptrdiff_t>(nodes.size()));
  Airway near{kept_rows(part.airway.first, local), kept_rows(part.airway.second, local),
              kept_rows(part.airway.tets, local), nullptr, part.airway.facing};
  if (near.first.rows() == 0 || near.second.rows() == 0)
    throw InvalidInput("Reduction", "contact_reach", scene.reduction->contact_reach, "m",
                       "as large as the surfaces are apart somewhere", "No face of the contact is within it.");

  beyond_ = rows_beyond(part.airway.tets, local);
  const std::vector<std::int32_t> turned = inverted(full.reference(), beyond_);
  if (!turned.empty())
    throw InvalidInput("Reduction", "contact_reach", scene.reduction->contact_reach, "m",
                       "so large that all air that is turned inside out at rest is within it");

  // A node of a face that was left out, beyond the reach itself, is on the rim.
  rim_.assign(nodes.size(), 0);
  for (const Triangles* side : {&part.airway.first, &part.airway.second})
    for (const auto& face : side->rowwise()) {
      const auto inside = [&](std::int32_t node) { return local[static_cast<std::size_t>(node)] >= 0; };
      if (std::all_of(face.begin(), face.end(), inside)) continue;
      for (const std::int32_t node : face)
        if (inside(node)) rim_[static_cast<std::size_t>(local[static_cast<std::size_t>(node)])] = 1;
    }

  held_ = Supports(nodes_.size());
  reference_ = full.reference()(nodes_, Eigen::all);
  shapes_ = motion.shapes_at(nodes_);
  Indices own(nodes_.size());
  for (std::int32_t i = 0; i < nodes_.size(); ++i) {
    own[i] = i;
    for (int c = 0; c < 3; ++c)
      if (scene.supports.fixed(3 * static_cast<std::ptrdiff_t>(nodes_[i]) + c)) held_.fix(i, c);
  }
  panels_ = PanelMatrix(shapes_);
  facing_ = near.facing;
  const std::vector<std::array<std::int32_t, 2>> pairs = facing_pairs(near, reference_);
  const auto count = static_cast<std::ptrdiff_t>(pairs.size());
  offsets_.resize(3 * count);
  offset_shapes_.resize(3 * count, motion.size());
  for (std::ptrdiff_t p = 0; p < count; ++p) {
    const auto [a, b] = pairs[static_cast<std::size_t>(p)];
    offsets_.segment<3>(3 * p) = (reference_.row(b) - reference_.row(a)).transpose().cast<float>();
    offset_shapes_.middleRows<3>(3 * p) =
        (shapes_.middleRows<3>(3 * b) - shapes_.middleRows<3>(3 * a)).cast<float>();
  }
  for (std::ptrdiff_t p = 0; p < count; ++p) {
    const Eigen::MatrixXd moves = offset_shapes_.middleRows<3>(3 * p).cast<double>();
    const Eigen::RowVectorXd apart = facing_.transpose() * moves;
    offset_speed_ = std::max(offset_speed_, apart.norm() + 2 * (moves - facing_ * apart).norm());
  }
  response_ = std::make_unique<const InterfaceResponse>(shapes_, motion.inverse());
  collision_.emplace(std::move(near), reference_, contact_method(part.enforcement), part.friction, part.options,
                     condensed_path(*response_, held_, own), part.faces);
}

Points ReducedCollision::positions(const Vector& q) const {
  Points x = reference_;
  Eigen::Map<Vector>(x.data(), x.size()) += panels_ * q;
  return x;
}

const Points& ReducedCollision::ends(const Vector& q) {
  if (end_.size() == 0 || q != end_) {
    at_end_ = positions(q);
    end_ = q;
  }
  return at_end_;
}

float ReducedCollision::clearance(const Eigen::VectorXf& offsets) const {
  if (offsets.size() == 0) return -1.0F;
  const float round_off = 1e-6F * static_cast<float>(collision_->detector().mean_edge());
  const Eigen::Vector3f facing = facing_.cast<float>();
  float least = std::numeric_limits<float>::infinity();
  for (std::ptrdiff_t at = 0; at < offsets.size(); at += 3) {
    const float along = offsets_.segment<3>(at).dot(facing) < 0 ? -1.0F : 1.0F;
    const float apart = offsets.segment<3>(at).dot(facing);
    const float slid = (offsets.segment<3>(at) - apart * facing).norm();
    const float over = along * apart - 2 * slid - round_off;
    least = over < least ? over : std::min(least, over);
    if (!(over > 0)) return over;
  }
  return least;
}

bool ReducedCollision::apart(const Vector& q) {
  if (apart_ > 0 && 1.001 * offset_speed_ * (q - apart_at_).norm() < apart_) return true;
  apart_at_ = q;
  apart_ = clearance(offsets(q));
  return apart_ > 0;
}

void ReducedCollision::begin(const State& last) {
  last_ = &last;
  near_ = false;
  never_near_ = true;
  contacts_ = {};
  force_ = Vector::Zero(3 * nodes_.size());
  load_ = acceleration_ = Vector::Zero(motion_.size());
  collision_->forget();
}

void ReducedCollision::touch(const Vector& free) {
  touches_ = false;
  force_.setZero();
  load_.setZero();
  acceleration_.setZero();
  near_ = !last_->closed.empty() || !apart(free);
  if (!near_) {
    contacts_ = {};
    return;
  }
  if (never_near_) x_before_ = ends(last_->displacement);
  never_near_ = false;
  const BeforeContact before{x_before_, last_->closed, last_->closed_force, last_->depth, nullptr};
  contacts_ = solve(before, positions(free), x_);
  touches_ = contacts_.any_force();
  if (!touches_) return;
  contacts_.add_forces(force_);
  for (std::ptrdiff_t i = 0; i < force_.size(); ++i)
    if (force_[i] != 0) load_ += force_[i] * shapes_.row(i).transpose();
  acceleration_ = motion_.solve(load_);
}

Contacts ReducedCollision::solve(const BeforeContact& before, const Points& x_free, Points& x) {
  const auto [alpha, beta, gamma] = motion_.scheme();
  const double inertia = beta * motion_.step() * motion_.step(), weight = 1 + alpha;
  if (std::holds_alternative<EndOfStep>(collision_->method().position()))
    return collision_->solve(x_free, inertia, before, std::move(contacts_), x);
  const Points weighted = weight * x_free - alpha * before.x;
  Contacts contacts = collision_->solve(weighted, weight * inertia, before, std::move(contacts_), x);
  x = (x + alpha * before.x) / weight;
  return contacts;
}

bool ReducedCollision::anywhere(const std::function<bool(const Vector3&)>& place) const {
  if (!near_) return false;
  for (std::size_t i = 0; i < contacts_.constraints.size(); ++i)
    if (contacts_.force[static_cast<std::ptrdiff_t>(i)] > 0 && place(x_.row(contacts_.constraints[i].slave)))
      return true;
  const Detector& detector = collision_->detector();
  const auto crossings = detector.edge_crossings(x_, detector.reach(x_before_, x_, last_->depth));
  return std::any_of(crossings.begin(), crossings.end(),
                     [&](const EdgeCrossing& crossing) { return place(crossing.place); });
}

ContactRecord ReducedCollision::record(const State& now) {
  if (never_near_) {
    pressure_.resize(0);
    return {};
  }
  const Points before = ends(last_->displacement), &x = ends(now.displacement);
  const Contact contact = now.contact_at_interface();
  collision_->update(x);
  pressure_ = collision_->pressure(contact, x);
  for (std::int32_t i = 0; i < nodes_.size(); ++i)
    if (rim_[static_cast<std::size_t>(i)] &&
        !contact.nodal_force.segment<3>(3 * static_cast<std::ptrdiff_t>(i)).isZero(0))
      throw SolveFailed("Reduction: contact at node " + std::to_string(nodes_[i]) + " (" + number(x(i, 0)) + ", " +
                        number(x(i, 1)) + ", " + number(x(i, 2)) +
                        ") m, on the rim of where it is looked for. Raise contact_reach.");
  return contact_record(*collision_, contacts_, before, last_->depth, contact, x);
}

void ReducedCollision::restore(const State& state) {
  const Points x = positions(state.displacement);
  collision_->update(x);
  pressure_ = collision_->pressure(state.contact_at_interface(), x);
}

Vector ReducedCollision::pressure() const {
  Vector everywhere = Vector::Zero(mesh_nodes_);
  if (pressure_.size() > 0) everywhere(nodes_) = pressure_;
  return everywhere;
}

Vector ReducedCollision::force(const Vector& interface_force) const {
  Points force = Points::Zero(mesh_nodes_, 3);
  force(nodes_, Eigen::all) = as_points(interface_force);
  return as_vector(force);
}

void ReducedCollision::require_open_beyond(const Points& x) const {
  const std::vector<std::int32_t> turned = inverted(x, beyond_);
  if (turned.empty()) return;
  const std::int32_t node = beyond_(turned.front(), 0);
  throw SolveFailed("Reduction: the surfaces have passed through each other at node " + std::to_string(node) +
                    " (" + number(x(node, 0)) + ", " + number(x(node, 1)) + ", " + number(x(node, 2)) +
                    ") m, beyond where contact is looked for. Raise contact_reach.");
}

}  // namespace plica
