// The simulated quadrotor: a rigid body under a sum of forces, with lagging motors.
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

#include "world/ground.hpp"

namespace stator::world {

inline constexpr unsigned kRotors = 4;
using RotorSpeeds = Eigen::Matrix<double, kRotors, 1>;  // rad/s

// A rotor thrusts along -z_B.
struct Rotor {
    double x;          // m, forward of the centre of mass
    double y;          // m, to the right
    double turns_ccw;  // 1: counter-clockwise seen from above; -1: clockwise
};

// Values of the Iris in PX4's Gazebo models, PX4-SITL_gazebo-classic models/iris/iris.sdf.jinja,
// unless a line says otherwise.
struct QuadParameters {
    double mass = 1.535;                              // kg, with the IMU and the rotors
    Vector3 inertia_B{0.029125, 0.029125, 0.055225};  // kg m^2, about the principal axes
    // In PX4's order: front right, rear left, front left, rear right.
    std::array<Rotor, kRotors> rotors{
        {{0.13, 0.22, 1.0}, {-0.13, -0.20, 1.0}, {0.13, -0.22, -1.0}, {-0.13, 0.20, -1.0}}};
    double thrust_per_speed2 = 5.84e-6;  // N s^2, k_T: thrust = k_T speed^2
    double torque_per_thrust = 0.06;     // m, k_M: the torque that turning the air costs
    double most_rotor_speed = 1100.0;    // rad/s
    double rotor_drag = 1.75e-4;         // N s^2/m, force = -k speed v, across the rotor's axis
    double rolling_moment = 1e-6;        // N s^2, torque = k speed v, of the wind across the axis
    // A rotor that climbs at pitch times speed has no thrust left: 25 m/s in hover.
    double inflow_pitch = 0.03114;       // m/rad
    double rise_time_constant = 0.0125;  // s, of a rotor that speeds up
    double fall_time_constant = 0.025;   // s
    // Of the airframe, drag coefficient times area. Not in the model above, whose airframe has no
    // drag: estimated for a 0.1 m x 0.25 m body and standing rotors; falls flat at 22 m/s.
    Vector3 drag_area_B{0.02, 0.02, 0.05};  // m^2
    double air_density = 1.225;             // kg/m^3, ISO 2533 at sea level
    // Electric power: momentum theory's for a hovering rotor of 10 inches, and half of it lost in
    // propeller, motor and controller; 171 W in hover, as its flight of 16 minutes on 5.1 Ah says.
    double disc_area = 0.0507;  // m^2, of a rotor
    double power_efficiency = 0.5;
    double avionics_power = 5.0;      // W
    double nominal_voltage = 11.877;  // V, of a full battery in hover: commands hold for this one
    double gravity = 9.80665;         // m/s^2, ISO 80000-3
    GroundParameters ground{};
};

struct QuadState {
    Vector3 position_N = Vector3::Zero();
    Vector3 velocity_N = Vector3::Zero();
    Quaternion q_NB = Quaternion::Identity();
    Vector3 rate_B = Vector3::Zero();
    RotorSpeeds rotor_speeds = RotorSpeeds::Zero();
};

// What acts on the vehicle besides its commands.
struct Influence {
    Vector3 wind_N = Vector3::Zero();                            // m/s
    double supply = 1.0;                                         // voltage, of the nominal one
    double current = 0.0;                                        // A, through the supply's wires
    std::array<double, kRotors> efficiency{1.0, 1.0, 1.0, 1.0};  // of each rotor's thrust
};

class Plant {
  public:
    Plant(const QuadParameters& parameters, const QuadState& start);

    // From now on. Each a fraction of a motor's most thrust, 0 to 1; not a number is stopped.
    void command(const std::array<float, kRotors>& control);
    void set_influence(const Influence& influence) { influence_ = influence; }
    // Moves on by a multiple of 1 us.
    void run_until(std::uint64_t time_us);
    // One Runge-Kutta step.
    void step(double dt);

    std::uint64_t time_us() const { return time_us_; }
    const QuadState& state() const { return state_; }
    const QuadParameters& parameters() const { return parameters_; }
    Vector3 specific_force_B() const;
    bool is_on_ground() const { return ground_.is_touched(); }
    const Influence& influence() const { return influence_; }
    Vector3 velocity_in_air_B() const;
    double lift_over_weight() const;
    double electric_power() const;  // W

  private:
    Wrench applied_wrench(const Motion& motion, const RotorSpeeds& speeds) const;
    QuadState derivative(const QuadState& state) const;

    QuadParameters parameters_;
    QuadState state_;
    Ground ground_;
    Influence influence_{};
    RotorSpeeds commanded_speeds_ = RotorSpeeds::Zero();  // at the nominal voltage
    std::uint64_t time_us_ = 0;
};

}  // namespace stator::world
