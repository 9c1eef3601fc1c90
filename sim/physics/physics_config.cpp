// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/physics/physics_world.hpp"

namespace swiftlet::sim {

void PhysicsConfig::visit(ConfigVisitor& v) {
  v.field("step_s", step_s, "[s] physics step, a whole number of nanoseconds", Range{1e-6, 0.02});
  v.field("motor_lag", motor_lag, "[-] rotors follow their command with a first-order lag");
  v.field("gyroscopic_torque", gyroscopic_torque, "[-] the rotors' angular momentum acts on the body");
  v.field("rotor_drag", rotor_drag, "[-] in-plane drag of the rotors acts on the body");
  v.field("body_drag", body_drag, "[-] quadratic drag acts on the body");
  v.field("ground_effect", ground_effect, "[-] rotors near a surface below give more thrust");
  v.field("downwash", downwash, "[-] rotor wakes push vehicles below");
  v.field("contacts", contacts, "[-] vehicles touch the world and each other");
  v.field("contact_friction", contact_friction, "[-] Coulomb friction of a vehicle", Range::between(0.0, 100.0));
  v.field("contact_restitution", contact_restitution, "[-] coefficient of restitution of contacts",
          Range::between(0.0, 1.0));
  v.field("crash_speed_mps", crash_speed_mps, "[m/s] normal speed above which a contact is a crash",
          Range::non_negative());
  v.field("propeller_contact_is_crash", propeller_contact_is_crash,
          "[-] a turning propeller that touches anything is a crash at any speed");
  v.field("stop_motors_on_crash", stop_motors_on_crash, "[-] a crashed vehicle's rotors stop");
}

}  // namespace swiftlet::sim
