// The simulated vehicle: a rigid body under a sum of forces, with lagging motors and servos.
//
//   position' = v_N          m v_N' = R_NB f_B + m g        (f_B: all forces but gravity)
//   q_NB' = q_NB (0, w_B)/2  I w_B' = t_B - w_B x I w_B     (t_B: all torques)
//   rotor speed' = (commanded speed - speed) / tau
//
// Integrated by the classical Runge-Kutta method in steps of at most 1 ms. Double, since positions
// and small steps add up. The origin of N is where the vehicle's centre of mass rests at height 0.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "world/ground.hpp"
#include "world/propeller.hpp"
#include "world/wing.hpp"

namespace stator::world {

inline constexpr unsigned kMaxRotors = 12;
using RotorSpeeds = Eigen::Matrix<double, kMaxRotors, 1>;  // rad/s; 0 without a rotor
// Of the motors: of rotors, and then of propellers.
using Controls = std::array<float, kMaxRotors>;

// A rotor thrusts along -z_B.
struct Rotor {
    Vector3 place_B;   // m, of its hub from the centre of mass
    double turns_ccw;  // 1: counter-clockwise seen from above; -1: clockwise
    double in_wake;    // part of the thrust that it has alone
};

// About the axes of B; the plane of x and z is one of symmetry.
struct Inertia {
    double xx = 0.0;
    double yy = 0.0;
    double zz = 0.0;
    double xz = 0.0;  // integral of x z over the mass

    Vector3 times(const Vector3& rate) const;
    Vector3 solve(const Vector3& torque) const;
};

// What graph/vehicles/NAME.yaml says of a vehicle's body; docs/reference.md describes the keys.
struct Airframe {
    double mass = 0.0;  // kg
    Inertia inertia{};  // kg m^2
    std::vector<Rotor> rotors{};
    double thrust_per_speed2 = 0.0;   // N s^2, k_T: thrust = k_T speed^2
    double torque_per_thrust = 0.0;   // m, k_M: the torque that turning the air costs
    double most_rotor_speed = 0.0;    // rad/s
    double rotor_drag = 0.0;          // N s^2/m, force = -k speed v, across the rotor's axis
    double rolling_moment = 0.0;      // N s^2, torque = k speed v, of the wind across the axis
    double inflow_pitch = 1.0;        // m/rad: at a climb of this times speed no thrust is left
    double rise_time_constant = 1.0;  // s, of a rotor that speeds up
    double fall_time_constant = 1.0;  // s
    Vector3 drag_area_B{0, 0, 0};     // m^2, of the airframe, drag coefficient times area
    double disc_area = 1.0;           // m^2, of a rotor
    double power_efficiency = 1.0;    // of propeller, motor and controller
    double avionics_power = 0.0;      // W
    double nominal_voltage = 1.0;     // V: commands hold for this one
    double gravity = 9.80665;         // m/s^2, ISO 80000-3
    GroundParameters ground{};
    Wing wing{};
    std::vector<Propeller> propellers{};  // at most kMaxPropellers

    unsigned rotor_count() const { return static_cast<unsigned>(rotors.size()); }
    unsigned motor_count() const {
        return static_cast<unsigned>(rotors.size() + propellers.size());
    }
    bool has_wing() const { return wing.area > 0.0; }
    // Feet of a multicopter are alike and below its centre; an aeroplane stands as its wheels are.
    Rest rest() const;
};

struct VehicleState {
    Vector3 position_N = Vector3::Zero();
    Vector3 velocity_N = Vector3::Zero();
    Quaternion q_NB = Quaternion::Identity();
    Vector3 rate_B = Vector3::Zero();
    RotorSpeeds rotor_speeds = RotorSpeeds::Zero();
    PropellerSpeeds propeller_speeds = PropellerSpeeds::Zero();
};

// What acts on the vehicle besides its commands.
struct Influence {
    Vector3 wind_N = Vector3::Zero();                     // m/s
    double supply = 1.0;                                  // voltage, of the nominal one
    double current = 0.0;                                 // A, through the supply's wires
    RotorSpeeds efficiency = RotorSpeeds::Constant(1.0);  // of each motor's thrust
    double air_density = 1.225;                           // kg/m^3, ISO 2533 at sea level
    // What a launcher or a hand makes of the vehicle's motion, whatever else acts.
    std::optional<Vector3> carried_N{};  // m/s^2
};

// Against the air, which forces of rotors and wings come from.
struct AirMotion {
    Vector3 velocity_B;
    Vector3 rate_B;
};

class Plant {
  public:
    Plant(const Airframe& parameters, const VehicleState& start);

    // From now on. Each a fraction of a motor's most thrust, 0 to 1; not a number is stopped.
    void command(const Controls& control);
    // Of the surfaces, each -1 to 1; not a number is neutral.
    void command_servos(const ServoControls& control) { servo_control_ = control; }
    // While a vehicle waits, its wheels are blocked.
    void block_wheels(bool are_blocked) { ground_.brake(are_blocked); }
    void set_influence(const Influence& influence) { influence_ = influence; }
    // Moves on by a multiple of 1 us.
    void run_until(std::uint64_t time_us);
    // One Runge-Kutta step.
    void step(double dt);

    std::uint64_t time_us() const { return time_us_; }
    const VehicleState& state() const { return state_; }
    const Airframe& parameters() const { return parameters_; }
    Vector3 specific_force_B() const;
    bool is_on_ground() const { return ground_.is_touched(); }
    const Influence& influence() const { return influence_; }
    Vector3 velocity_in_air_B() const;
    double lift_over_weight() const;
    // Of the mean motor, as it shakes the airframe: 1 in hover.
    double mean_load() const;
    const Deflections& deflections() const { return deflections_; }
    double electric_power() const;  // W

  private:
    Wrench applied_wrench(const Motion& motion, const VehicleState& state,
                          PropellerSpeeds& propeller_rates) const;
    VehicleState derivative(const VehicleState& state) const;
    Wrench add_propellers(const AirMotion& motion, const VehicleState& state,
                          PropellerSpeeds& rates) const;
    void move_surfaces(double dt);

    Airframe parameters_;
    VehicleState state_;
    Ground ground_;
    Influence influence_{};
    RotorSpeeds commanded_speeds_ = RotorSpeeds::Zero();      // at the nominal voltage
    PropellerSpeeds shaft_powers_ = PropellerSpeeds::Zero();  // W, at the nominal voltage
    ServoControls servo_control_{};
    Deflections deflections_{};
    std::uint64_t time_us_ = 0;
};

}  // namespace stator::world
