// SPDX-License-Identifier: BSD-3-Clause
#include "sim/physics/contacts.hpp"

#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace swiftlet::sim {
namespace {

// [m] Half of the height of a propeller disc, coning included.
constexpr double kDiscHalfHeight_m = 0.01;
// [m] Half of the width of the boxes that model arms.
constexpr double kArmHalfWidth_m = 0.012;
// [m] Radius of the capsules that model legs.
constexpr double kFootRadius_m = 0.012;
// Positions of the skids' ends in body radii, as in sim/world/vehicle_shape.cpp.
constexpr double kFootAhead = 1.5;
constexpr double kFootAside = 1.3;
// [m] Distance of a contact that must not act: no impulse bridges it within a step.
constexpr double kOutOfReach_m = 1.0;

btVector3 to_bt(const Vector3& v) { return {v.x(), v.y(), v.z()}; }
Vector3 from_bt(const btVector3& v) { return {v.x(), v.y(), v.z()}; }
btQuaternion to_bt(const Eigen::Quaterniond& q) { return {q.x(), q.y(), q.z(), q.w()}; }

struct Triangle {
  std::array<btVector3, 3> corners;
  btVector3 low, high;
};

/// The static world for Bullet's collision algorithms: the triangles near the current vehicle.
class NearTriangles final : public btConcaveShape {
 public:
  NearTriangles() {
    m_shapeType = FAST_CONCAVE_MESH_PROXYTYPE;  // Bullet treats the "custom" type as a signed distance field
    m_collisionMargin = 0.0;
  }

  void show(const std::vector<Triangle>& triangles, const btVector3& low, const btVector3& high) {
    triangles_ = &triangles;
    low_ = low;
    high_ = high;
  }

  void processAllTriangles(btTriangleCallback* callback, const btVector3& low, const btVector3& high) const override {
    const int count = static_cast<int>(triangles_->size());
    for (int i = 0; i < count; ++i) {
      const Triangle& triangle = (*triangles_)[i];
      if (!TestAabbAgainstAabb2(low, high, triangle.low, triangle.high)) continue;
      std::array<btVector3, 3> corners = triangle.corners;
      callback->processTriangle(corners.data(), 0, i);
    }
  }

  void getAabb(const btTransform& T, btVector3& low, btVector3& high) const override {
    btTransformAabb(low_, high_, 0.0, T, low, high);
  }
  void setLocalScaling(const btVector3&) override {}
  const btVector3& getLocalScaling() const override { return scaling_; }
  void calculateLocalInertia(btScalar, btVector3& inertia) const override { inertia.setZero(); }
  const char* getName() const override { return "NearTriangles"; }

 private:
  const std::vector<Triangle>* triangles_ = nullptr;
  btVector3 low_{-1.0, -1.0, -1.0};
  btVector3 high_{1.0, 1.0, 1.0};
  btVector3 scaling_{1.0, 1.0, 1.0};
};

/// Collision shape of one airframe; marks the propellers among its parts.
struct VehicleHull {
  std::vector<std::unique_ptr<btConvexShape>> parts;
  std::unique_ptr<btCompoundShape> compound = std::make_unique<btCompoundShape>(true);
  int first_propeller = 0;
  int end_propeller = 0;
  double reach_m = 0.0;

  void add(std::unique_ptr<btConvexShape> part, const btTransform& T_body_part) {
    compound->addChildShape(T_body_part, part.get());
    parts.push_back(std::move(part));
  }
  bool is_propeller(int part) const { return part >= first_propeller && part < end_propeller; }
};

btTransform frame_along(const btVector3& center, const btVector3& own_axis, const btVector3& wanted_axis) {
  return btTransform(shortestArcQuat(own_axis, wanted_axis.normalized()), center);
}

VehicleHull make_hull(const Airframe& airframe) {
  VehicleHull hull;
  const btVector3 x_axis(1, 0, 0);
  const btVector3 z_axis(0, 0, 1);
  hull.add(std::make_unique<btCylinderShapeZ>(
               btVector3(airframe.body_radius_m, airframe.body_radius_m, 0.5 * airframe.body_height_m)),
           btTransform::getIdentity());

  hull.first_propeller = static_cast<int>(hull.parts.size());
  for (const Rotor& rotor : airframe.rotors) {
    hull.add(std::make_unique<btCylinderShapeZ>(
                 btVector3(airframe.propeller_radius_m, airframe.propeller_radius_m, kDiscHalfHeight_m)),
             btTransform(btQuaternion::getIdentity(), to_bt(rotor.position_m)));
  }
  hull.end_propeller = static_cast<int>(hull.parts.size());

  for (const Rotor& rotor : airframe.rotors) {
    // From the center to just below the hub, so that the propeller disc is outermost.
    const btVector3 tip = to_bt(rotor.position_m) - btVector3(0, 0, 2.0 * kDiscHalfHeight_m + kArmHalfWidth_m);
    if (tip.length() < 2.0 * kArmHalfWidth_m) continue;
    hull.add(std::make_unique<btBoxShape>(btVector3(0.5 * tip.length(), kArmHalfWidth_m, kArmHalfWidth_m)),
             frame_along(0.5 * tip, x_axis, tip));
  }

  // Four legs that end in spheres: each gives one steady contact on any ground.
  const double top_m = 0.25 * airframe.body_height_m;
  for (int i = 0; i < 4; ++i) {
    const double side_x = (i & 1) != 0 ? 1.0 : -1.0;
    const double side_y = (i & 2) != 0 ? 1.0 : -1.0;
    const btVector3 foot(side_x * kFootAhead * airframe.body_radius_m, side_y * kFootAside * airframe.body_radius_m,
                         -airframe.leg_height_m + kFootRadius_m);
    const btVector3 root(0.5 * foot.x(), 0.5 * foot.y(), std::max(-top_m, foot.z() + 0.001));
    hull.add(std::make_unique<btCapsuleShapeZ>(kFootRadius_m, (root - foot).length()),
             frame_along(0.5 * (root + foot), z_axis, root - foot));
  }

  btVector3 low, high;
  hull.reach_m = airframe.circumscribed_radius_m();
  for (int i = 0; i < hull.compound->getNumChildShapes(); ++i) {
    btVector3 center;
    btScalar radius;
    hull.compound->getChildShape(i)->getBoundingSphere(center, radius);
    hull.compound->getChildShape(i)->getAabb(hull.compound->getChildTransform(i), low, high);
    hull.reach_m = std::max(hull.reach_m, double(low.absolute().length()));
    hull.reach_m = std::max(hull.reach_m, double(high.absolute().length()));
  }
  return hull;
}

/// Bullet's representation of one vehicle.
struct Body {
  VehicleHull hull;
  std::unique_ptr<btRigidBody> rigid;
  std::vector<Triangle> triangles;  // triangles within reach in this tick
  btVector3 low, high;
  btCollisionAlgorithm* world_algorithm = nullptr;
};

struct PairAlgorithm {
  Contacts::Pair pair;
  btCollisionAlgorithm* algorithm = nullptr;
};

btDefaultCollisionConstructionInfo pool_sizes(std::size_t num_parts) {
  // Every part keeps a manifold and an algorithm for the world; pairs of vehicles need further ones.
  btDefaultCollisionConstructionInfo info;
  info.m_defaultMaxPersistentManifoldPoolSize = static_cast<int>(num_parts) + 1024;
  info.m_defaultMaxCollisionAlgorithmPoolSize = 2 * static_cast<int>(num_parts) + 1024;
  return info;
}

std::size_t count_parts(std::span<const PhysicsVehicle> vehicles) {
  std::size_t count = 0;
  for (const PhysicsVehicle& vehicle : vehicles) count += 6 + 2 * vehicle.airframe.rotors.size();
  return count;
}

}  // namespace

struct Contacts::Impl {
  Impl(std::span<const PhysicsVehicle> vehicles, const PhysicsConfig& config)
      : configuration(pool_sizes(count_parts(vehicles))), dispatcher(&configuration) {
    dispatcher.setDispatcherFlags(0);  // contact margins as absolute lengths
    world.setCollisionShape(&near_triangles);
    world.setCollisionFlags(btCollisionObject::CF_STATIC_OBJECT);
    world.setWorldTransform(btTransform::getIdentity());
    world.setFriction(1.0);
    world.setRestitution(1.0);
    world.setUserIndex(kNoVehicle);

    dispatch_info.m_timeStep = config.step_s;
    solver_info.m_timeStep = config.step_s;
    solver_info.m_numIterations = 20;
    solver_info.m_splitImpulse = true;                     // resolving a penetration adds no speed
    solver_info.m_splitImpulsePenetrationThreshold = 1.0;  // disabled
    solver_info.m_restitutionVelocityThreshold = 0.1;
    solver_info.m_solverMode = SOLVER_USE_WARMSTARTING | SOLVER_USE_2_FRICTION_DIRECTIONS |
                               SOLVER_DISABLE_VELOCITY_DEPENDENT_FRICTION_DIRECTION;

    bodies.reserve(vehicles.size());
    for (const PhysicsVehicle& vehicle : vehicles) bodies.push_back(make_body(vehicle.airframe, config));
    manifolds.reserve(256);
    approaches.reserve(1024);
  }

  ~Impl() {
    for (const Body& body : bodies) destroy(body.world_algorithm);
    for (const PairAlgorithm& pair : pair_algorithms) destroy(pair.algorithm);
  }

  Body make_body(const Airframe& airframe, const PhysicsConfig& config) {
    Body body;
    body.hull = make_hull(airframe);
    btRigidBody::btRigidBodyConstructionInfo info(airframe.mass_kg, nullptr, body.hull.compound.get(),
                                                  to_bt(airframe.inertia_diagonal_kgm2));
    info.m_friction = config.contact_friction;
    info.m_restitution = config.contact_restitution;
    body.rigid = std::make_unique<btRigidBody>(info);
    body.rigid->setFlags(0);  // gyroscopic torque is part of the flight model
    body.rigid->setActivationState(DISABLE_DEACTIVATION);
    body.rigid->setUserIndex(static_cast<int>(bodies.size()));
    // The algorithm of the pair (vehicle, world) is created in advance, so that flying low allocates nothing.
    near_triangles.show(no_triangles, {-1.0, -1.0, -1.0}, {1.0, 1.0, 1.0});
    const btCollisionObjectWrapper vehicle = wrap(*body.rigid);
    const btCollisionObjectWrapper ground = wrap(world);
    body.world_algorithm = dispatcher.findAlgorithm(&vehicle, &ground, nullptr, BT_CONTACT_POINT_ALGORITHMS);
    body.triangles.reserve(256);
    return body;
  }

  static btCollisionObjectWrapper wrap(const btCollisionObject& object) {
    return {nullptr, object.getCollisionShape(), &object, object.getWorldTransform(), -1, -1};
  }

  void destroy(btCollisionAlgorithm* algorithm) {
    if (algorithm == nullptr) return;
    algorithm->~btCollisionAlgorithm();
    dispatcher.freeCollisionAlgorithm(algorithm);
  }

  btCollisionAlgorithm* algorithm_of(Contacts::Pair pair, const btCollisionObjectWrapper& a,
                                     const btCollisionObjectWrapper& b) {
    for (const PairAlgorithm& known : pair_algorithms) {
      if (known.pair.a == pair.a && known.pair.b == pair.b) return known.algorithm;
    }
    pair_algorithms.push_back({pair, dispatcher.findAlgorithm(&a, &b, nullptr, BT_CONTACT_POINT_ALGORITHMS)});
    return pair_algorithms.back().algorithm;
  }

  void collide(const btCollisionObject& a, const btCollisionObject& b, btCollisionAlgorithm* algorithm) {
    const btCollisionObjectWrapper wrapped_a = wrap(a);
    const btCollisionObjectWrapper wrapped_b = wrap(b);
    btManifoldResult result(&wrapped_a, &wrapped_b);
    algorithm->processCollision(&wrapped_a, &wrapped_b, dispatch_info, &result);
    algorithm->getAllContactManifolds(manifolds);
  }

  void place(const ContactBody& body) {
    btRigidBody& rigid = *bodies[body.vehicle].rigid;
    rigid.setWorldTransform(btTransform(to_bt(body.q_world_body), to_bt(body.p_world_m)));
    rigid.setInterpolationWorldTransform(rigid.getWorldTransform());
    rigid.updateInertiaTensor();
    rigid.setLinearVelocity(to_bt(body.v_world_mps));
    rigid.setAngularVelocity(to_bt(body.omega_world_radps));
  }

  static btVector3 velocity_at(const btCollisionObject& object, const btVector3& p_world) {
    const btRigidBody* rigid = btRigidBody::upcast(&object);
    if (rigid == nullptr) return {0.0, 0.0, 0.0};
    return rigid->getVelocityInLocalPoint(p_world - rigid->getWorldTransform().getOrigin());
  }

  /// Normal speed of every contact point before the impulses, in the order of the manifolds. A restituting surface
  /// counts as touched in the step that reaches it and as absent before: Bullet would otherwise first close the gap and
  /// lose part of the rebound.
  void note_approaches() {
    approaches.clear();
    for (int m = 0; m < manifolds.size(); ++m) {
      btPersistentManifold& manifold = *manifolds[m];
      for (int k = 0; k < manifold.getNumContacts(); ++k) {
        btManifoldPoint& point = manifold.getContactPoint(k);
        const btVector3 relative = velocity_at(*manifold.getBody0(), point.getPositionWorldOnA()) -
                                   velocity_at(*manifold.getBody1(), point.getPositionWorldOnB());
        const double approach = -relative.dot(point.m_normalWorldOnB);
        approaches.push_back(approach);
        const bool bounces = point.m_combinedRestitution > 0.0 && approach > solver_info.m_restitutionVelocityThreshold;
        if (bounces && point.getDistance() > 0.0) {
          const bool hit = approach * solver_info.m_timeStep > point.getDistance();
          point.setDistance(hit ? 0.0 : kOutOfReach_m);
        }
      }
    }
  }

  void report(std::vector<Touch>& touches) const {
    std::size_t i = 0;
    for (int m = 0; m < manifolds.size(); ++m) {
      const btPersistentManifold& manifold = *manifolds[m];
      const VehicleId a = manifold.getBody0()->getUserIndex();
      const VehicleId b = manifold.getBody1()->getUserIndex();
      for (int k = 0; k < manifold.getNumContacts(); ++k, ++i) {
        const btManifoldPoint& point = manifold.getContactPoint(k);
        if (point.getAppliedImpulse() <= 0.0) continue;
        const Vector3 p_world = from_bt(point.getPositionWorldOnB());
        const bool propeller_a = a != kNoVehicle && bodies[a].hull.is_propeller(point.m_index0);
        const bool propeller_b = b != kNoVehicle && bodies[b].hull.is_propeller(point.m_index1);
        if (a != kNoVehicle) touches.push_back({a, b, p_world, approaches[i], propeller_a, propeller_b});
        if (b != kNoVehicle) touches.push_back({b, a, p_world, approaches[i], propeller_b, propeller_a});
      }
    }
  }

  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher;
  btSequentialImpulseConstraintSolver solver;
  btContactSolverInfo solver_info;
  btDispatcherInfo dispatch_info;
  NearTriangles near_triangles;
  std::vector<Triangle> no_triangles;
  btCollisionObject world;
  std::vector<Body> bodies;
  std::vector<PairAlgorithm> pair_algorithms;
  btManifoldArray manifolds;                         // contact manifolds of this step
  btAlignedObjectArray<btCollisionObject*> objects;  // colliding objects of this step
  std::vector<double> approaches;
};

Contacts::Contacts(std::span<const PhysicsVehicle> vehicles, const PhysicsConfig& config)
    : impl_(std::make_unique<Impl>(vehicles, config)) {}
Contacts::~Contacts() = default;

double Contacts::reach_m(VehicleId vehicle) const { return impl_->bodies[vehicle].hull.reach_m; }

void Contacts::gather_triangles(VehicleId vehicle, const StaticScene& scene, const Eigen::AlignedBox3d& box_world) {
  Body& body = impl_->bodies[vehicle];
  body.triangles.clear();
  body.low = to_bt(box_world.min());
  body.high = to_bt(box_world.max());
  scene.triangles_near_box(box_world, [&body](const Vector3& a, const Vector3& b, const Vector3& c, int) {
    if ((b - a).cross(c - a).squaredNorm() < 1e-24) return;  // degenerate triangle without normal
    Triangle triangle{
        {to_bt(a), to_bt(b), to_bt(c)}, to_bt(a.cwiseMin(b).cwiseMin(c)), to_bt(a.cwiseMax(b).cwiseMax(c))};
    if (TestAabbAgainstAabb2(triangle.low, triangle.high, body.low, body.high)) body.triangles.push_back(triangle);
  });
}

Contacts::Overlap Contacts::overlap(VehicleId vehicle, const Vector3& p_world_m,
                                    const Eigen::Quaterniond& q_world_body) {
  Impl& impl = *impl_;
  Body& own = impl.bodies[vehicle];
  // Discards Bullet's cached contacts of the previous position.
  impl.manifolds.resizeNoInitialize(0);
  own.world_algorithm->getAllContactManifolds(impl.manifolds);
  for (int m = 0; m < impl.manifolds.size(); ++m) impl.manifolds[m]->clearManifold();
  impl.manifolds.resizeNoInitialize(0);

  ContactBody body;
  body.vehicle = vehicle;
  body.p_world_m = p_world_m;
  body.q_world_body = q_world_body;
  impl.place(body);
  impl.near_triangles.show(own.triangles, own.low, own.high);
  if (!own.triangles.empty()) impl.collide(*own.rigid, impl.world, own.world_algorithm);

  Overlap deepest;
  for (int m = 0; m < impl.manifolds.size(); ++m) {
    for (int k = 0; k < impl.manifolds[m]->getNumContacts(); ++k) {
      const btManifoldPoint& point = impl.manifolds[m]->getContactPoint(k);
      if (-point.getDistance() > deepest.depth_m)
        deepest = {-point.getDistance(), from_bt(point.getPositionWorldOnB())};
    }
  }
  return deepest;
}

void Contacts::resolve(std::span<ContactBody> bodies, std::span<const Pair> pairs, std::vector<Touch>& touches) {
  Impl& impl = *impl_;
  impl.manifolds.resizeNoInitialize(0);
  for (const ContactBody& body : bodies) impl.place(body);

  // Narrow phase.
  for (const ContactBody& body : bodies) {
    Body& own = impl.bodies[body.vehicle];
    if (!body.near_world || own.triangles.empty()) continue;
    impl.near_triangles.show(own.triangles, own.low, own.high);
    impl.collide(*own.rigid, impl.world, own.world_algorithm);
  }
  for (const Pair& pair : pairs) {
    const btRigidBody& a = *impl.bodies[pair.a].rigid;
    const btRigidBody& b = *impl.bodies[pair.b].rigid;
    impl.collide(a, b, impl.algorithm_of(pair, Impl::wrap(a), Impl::wrap(b)));
  }
  int kept = 0;
  for (int m = 0; m < impl.manifolds.size(); ++m) {
    if (impl.manifolds[m]->getNumContacts() > 0) impl.manifolds[kept++] = impl.manifolds[m];
  }
  impl.manifolds.resizeNoInitialize(kept);
  if (kept == 0) return;

  // Impulses.
  impl.note_approaches();
  impl.objects.resizeNoInitialize(0);
  for (const ContactBody& body : bodies) impl.objects.push_back(impl.bodies[body.vehicle].rigid.get());
  impl.solver.solveGroup(&impl.objects[0], impl.objects.size(), &impl.manifolds[0], kept, nullptr, 0, impl.solver_info,
                         nullptr, &impl.dispatcher);
  const std::size_t first = touches.size();
  impl.report(touches);

  for (ContactBody& body : bodies) {
    body.touched = std::any_of(touches.begin() + static_cast<std::ptrdiff_t>(first), touches.end(),
                               [&](const Touch& touch) { return touch.vehicle == body.vehicle; });
    if (!body.touched) continue;
    const btRigidBody& rigid = *impl.bodies[body.vehicle].rigid;
    body.p_world_m = from_bt(rigid.getWorldTransform().getOrigin());
    const btQuaternion q = rigid.getWorldTransform().getRotation();
    body.q_world_body = Eigen::Quaterniond(q.w(), q.x(), q.y(), q.z()).normalized();
    body.v_world_mps = from_bt(rigid.getLinearVelocity());
    body.omega_world_radps = from_bt(rigid.getAngularVelocity());
  }
}

}  // namespace swiftlet::sim
