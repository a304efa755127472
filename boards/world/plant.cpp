// The simulated vehicle.
#include "world/plant.hpp"

namespace stator::world {

namespace {

constexpr std::uint64_t kLongestStep_us = 1000;

Motion motion_of(const VehicleState& state) {
    return {state.position_N, state.velocity_N, state.q_NB.toRotationMatrix(), state.rate_B};
}

// state + rate * dt. The quaternion leaves unit length; `step` brings it back.
VehicleState moved(const VehicleState& state, const VehicleState& rate, double dt) {
    return {.position_N = state.position_N + rate.position_N * dt,
            .velocity_N = state.velocity_N + rate.velocity_N * dt,
            .q_NB = Quaternion(state.q_NB.coeffs() + rate.q_NB.coeffs() * dt),
            .rate_B = state.rate_B + rate.rate_B * dt,
            .rotor_speeds = state.rotor_speeds + rate.rotor_speeds * dt};
}

RotorSpeeds lag(const Airframe& parameters, const RotorSpeeds& commanded,
                const RotorSpeeds& speeds) {
    RotorSpeeds rate = RotorSpeeds::Zero();
    for (unsigned i = 0; i < parameters.rotor_count(); ++i) {
        const double error = commanded[i] - speeds[i];
        rate[i] =
            error / (error > 0.0 ? parameters.rise_time_constant : parameters.fall_time_constant);
    }
    return rate;
}

Wrench operator+(const Wrench& a, const Wrench& b) {
    return {a.force_B + b.force_B, a.torque_B + b.torque_B};
}

// How deep the feet of a vehicle at rest press the ground's springs.
double rest_depth(const Airframe& parameters) {
    return parameters.mass * parameters.gravity /
           (parameters.ground.feet * parameters.ground.stiffness);
}

// Against the air, which a rotor's drag and inflow come from.
struct AirMotion {
    Vector3 velocity_B;
    Vector3 rate_B;
};

// k_T speed^2, less what the air that comes towards the rotor takes.
double rotor_thrust(const Airframe& parameters, double speed, double climb) {
    return parameters.thrust_per_speed2 * speed * (speed - climb / parameters.inflow_pitch);
}

Wrench rotor_wrench(const Airframe& parameters, unsigned i, const AirMotion& motion, double speed,
                    double efficiency) {
    const Rotor& rotor = parameters.rotors[i];
    const Vector3& arm_B = rotor.place_B;
    const Vector3 hub_B = motion.velocity_B + motion.rate_B.cross(arm_B);
    const double thrust = efficiency * rotor_thrust(parameters, speed, -hub_B.z());
    const Vector3 across_B(hub_B.x(), hub_B.y(), 0.0);
    const Vector3 drag_B = -parameters.rotor_drag * speed * across_B;
    const Vector3 force_B(drag_B.x(), drag_B.y(), -thrust);
    Wrench wrench{force_B, arm_B.cross(force_B)};
    // The blade that meets the wind lifts more than the one that flees it.
    wrench.torque_B -= rotor.turns_ccw * parameters.rolling_moment * speed * across_B;
    wrench.torque_B.z() += rotor.turns_ccw * parameters.torque_per_thrust * thrust;
    return wrench;
}

// By halves.
double sum_of_squares(const RotorSpeeds& speeds, unsigned first, unsigned count) {
    if (count == 0) return 0.0;
    if (count == 1) return speeds[first] * speeds[first];
    const unsigned half = count / 2;
    return sum_of_squares(speeds, first, half) + sum_of_squares(speeds, first + half, count - half);
}

Wrench body_drag(const Airframe& parameters, const Vector3& velocity_B) {
    const double pressure_per_speed = 0.5 * parameters.air_density * math::norm(velocity_B);
    return {-pressure_per_speed * parameters.drag_area_B.cwiseProduct(velocity_B), Vector3::Zero()};
}

}  // namespace

Vector3 Inertia::times(const Vector3& rate) const {
    return {xx * rate.x() - xz * rate.z(), yy * rate.y(), zz * rate.z() - xz * rate.x()};
}

Vector3 Inertia::solve(const Vector3& torque) const {
    const double roll = (torque.x() + xz * torque.z() / zz) / (xx - xz * xz / zz);
    return {roll, torque.y() / yy, (torque.z() + xz * roll) / zz};
}

Plant::Plant(const Airframe& parameters, const VehicleState& start)
    : parameters_(parameters),
      state_(start),
      ground_(parameters.ground, parameters.ground.points_B[0].z() - rest_depth(parameters)) {
    ground_.settle(motion_of(state_));
}

void Plant::command(const Controls& control) {
    for (unsigned i = 0; i < parameters_.rotor_count(); ++i) {
        const double fraction = math::is_nan(control[i]) ? 0.0 : static_cast<double>(control[i]);
        commanded_speeds_[i] =
            parameters_.most_rotor_speed * math::sqrt(math::clamp(fraction, 0.0, 1.0));
    }
}

void Plant::run_until(std::uint64_t time_us) {
    while (time_us_ < time_us) {
        const std::uint64_t left = time_us - time_us_;
        const std::uint64_t dt_us = left < kLongestStep_us ? left : kLongestStep_us;
        step(static_cast<double>(dt_us) * 1e-6);
        time_us_ += dt_us;
    }
}

void Plant::step(double dt) {
    const VehicleState k1 = derivative(state_);
    const VehicleState k2 = derivative(moved(state_, k1, 0.5 * dt));
    const VehicleState k3 = derivative(moved(state_, k2, 0.5 * dt));
    const VehicleState k4 = derivative(moved(state_, k3, dt));
    const VehicleState sum = moved(moved(moved(k1, k2, 2.0), k3, 2.0), k4, 1.0);
    state_ = moved(state_, sum, dt / 6.0);
    state_.q_NB = math::normalized(state_.q_NB);
    ground_.settle(motion_of(state_));
}

Wrench Plant::applied_wrench(const Motion& motion, const RotorSpeeds& speeds) const {
    const AirMotion in_air{motion.R_NB.transpose() * (motion.velocity_N - influence_.wind_N),
                           motion.rate_B};
    Wrench sum = body_drag(parameters_, in_air.velocity_B) + ground_.wrench(motion);
    for (unsigned i = 0; i < parameters_.rotor_count(); ++i) {
        const double efficiency = parameters_.rotors[i].in_wake * influence_.efficiency[i];
        sum = sum + rotor_wrench(parameters_, i, in_air, speeds[i], efficiency);
    }
    return sum;
}

VehicleState Plant::derivative(const VehicleState& state) const {
    const Motion motion = motion_of(state);
    const Wrench wrench = applied_wrench(motion, state.rotor_speeds);
    const Vector3 gravity_N(0.0, 0.0, parameters_.gravity);
    const Vector3 momentum_B = parameters_.inertia.times(state.rate_B);
    const Vector3 torque_B = wrench.torque_B - state.rate_B.cross(momentum_B);
    const Vector3 half_rate_B = 0.5 * state.rate_B;
    const Quaternion turning(0.0, half_rate_B.x(), half_rate_B.y(), half_rate_B.z());
    return {.position_N = state.velocity_N,
            .velocity_N = motion.R_NB * wrench.force_B / parameters_.mass + gravity_N,
            .q_NB = state.q_NB * turning,
            .rate_B = parameters_.inertia.solve(torque_B),
            .rotor_speeds =
                lag(parameters_, influence_.supply * commanded_speeds_, state.rotor_speeds)};
}

Vector3 Plant::specific_force_B() const {
    return applied_wrench(motion_of(state_), state_.rotor_speeds).force_B / parameters_.mass;
}

Vector3 Plant::velocity_in_air_B() const {
    return state_.q_NB.toRotationMatrix().transpose() * (state_.velocity_N - influence_.wind_N);
}

double Plant::lift_over_weight() const {
    return parameters_.thrust_per_speed2 *
           sum_of_squares(state_.rotor_speeds, 0, parameters_.rotor_count()) /
           (parameters_.mass * parameters_.gravity);
}

double Plant::electric_power() const {
    double sum = 0.0;  // of thrust to the power of 3/2
    for (unsigned i = 0; i < parameters_.rotor_count(); ++i) {
        const double speed = state_.rotor_speeds[i];
        const double thrust = parameters_.thrust_per_speed2 * speed * speed;
        sum += thrust * math::sqrt(thrust);
    }
    const double induced = sum / math::sqrt(2.0 * parameters_.air_density * parameters_.disc_area);
    return induced / parameters_.power_efficiency + parameters_.avionics_power;
}

}  // namespace stator::world
