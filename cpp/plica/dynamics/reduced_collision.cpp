#include "plica/dynamics/reduced_collision.hpp"

#include <algorithm>
#include <limits>

#include "plica/core/error.hpp"
#include "plica/dynamics/contact_record.hpp"
#include "plica/dynamics/interface_response.hpp"

namespace plica {

namespace {

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

ReducedCollision::ReducedCollision(const Scene& scene, const Motion& full, const ModalMotion& motion,
                                   const Mediolateral& positions)
    : motion_(motion), mediolateral_(positions), mesh_nodes_(scene.mesh.node_count()), held_(0) {
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
  const Airway near{kept_rows(part.airway.first, local), kept_rows(part.airway.second, local),
                    kept_rows(part.airway.tets, local), nullptr, part.airway.facing};
  if (near.first.rows() == 0 || near.second.rows() == 0)
    throw InvalidInput("Reduction", "contact_reach", scene.reduction->contact_reach, "m",
                       "as large as the surfaces are apart somewhere", "No face of the contact is within it.");

  beyond_ = rows_beyond(part.airway.tets, local);
  const std::vector<std::int32_t> turned = find_inverted(full.reference(), beyond_);
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
  response_ = std::make_unique<const InterfaceResponse>(shapes_, motion.inverse());
  collision_.emplace(near, reference_, contact_method(part.enforcement), part.friction, part.options,
                     condensed_path(*response_, held_, own), part.faces);
  clearance_.emplace(near, reference_, shapes_, collision_->detector().mean_edge());
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

void ReducedCollision::begin(const State& last) {
  last_ = &last;
  near_ = false;
  never_near_ = true;
  contacts_ = {};
  force_ = Vector::Zero(3 * nodes_.size());
  load_ = acceleration_ = Vector::Zero(motion_.size());
  collision_->forget();
}

void ReducedCollision::touch(const FreeEnd& move) {
  const Vector free = move.free_end();
  touches_ = false;
  force_.setZero();
  load_.setZero();
  acceleration_.setZero();
  near_ = !last_->closed.empty() || !clearance_->apart(free);
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
  x_acceleration_ = mediolateral_.change(acceleration_);
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
      throw SolveFailed("Reduction: contact at node " + std::to_string(nodes_[i]) + " (" + number_text(x(i, 0)) +
                        ", " + number_text(x(i, 1)) + ", " + number_text(x(i, 2)) +
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
  const std::vector<std::int32_t> turned = find_inverted(x, beyond_);
  if (turned.empty()) return;
  const std::int32_t node = beyond_(turned.front(), 0);
  throw SolveFailed("Reduction: the surfaces have passed through each other at node " + std::to_string(node) +
                    " (" + number_text(x(node, 0)) + ", " + number_text(x(node, 1)) + ", " +
                    number_text(x(node, 2)) + ") m, beyond where contact is looked for. Raise contact_reach.");
}

}  // namespace plica
