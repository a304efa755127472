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
            .rotor_speeds = state.rotor_speeds + rate.rotor_speeds * dt,
            .propeller_speeds = state.propeller_speeds + rate.propeller_speeds * dt};
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

// How deep the feet of a vehicle at rest press the ground's springs.
double rest_depth(const Airframe& parameters) {
    return parameters.mass * parameters.gravity /
           (parameters.ground.feet * parameters.ground.stiffness);
}

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

Wrench body_drag(const Airframe& parameters, const Vector3& velocity_B, double air_density) {
    const double pressure_per_speed = 0.5 * air_density * math::norm(velocity_B);
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

Rest Airframe::rest() const {
    if (has_wing()) return rest_of(ground, mass * gravity);
    return {.surface_z = ground.points_B[0].z() - rest_depth(*this)};
}

Plant::Plant(const Airframe& parameters, const VehicleState& start)
    : parameters_(parameters),
      state_(start),
      ground_(parameters.ground, parameters.rest().surface_z) {
    ground_.settle(motion_of(state_));
    command({});
}

void Plant::command(const Controls& control) {
    const unsigned rotors = parameters_.rotor_count();
    for (unsigned i = 0; i < parameters_.propellers.size(); ++i) {
        const float wanted = control[rotors + i];
        const double throttle = math::is_nan(wanted) ? 0.0 : static_cast<double>(wanted);
        shaft_powers_[i] =
            polynomial(parameters_.propellers[i].shaft_power, math::clamp(throttle, 0.0, 1.0));
    }
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

void Plant::move_surfaces(double dt) {
    if (parameters_.wing.surfaces.empty()) return;
    move_servos(parameters_.wing, servo_control_, dt, deflections_);
    const std::vector<Wheel>& wheels = parameters_.ground.wheels;
    for (unsigned i = 0; i < wheels.size(); ++i) {
        if (wheels[i].steered_by < 0) continue;
        const auto surface = static_cast<std::size_t>(wheels[i].steered_by);
        ground_.steer(i, wheels[i].steering * deflections_[surface]);
    }
}

void Plant::step(double dt) {
    move_surfaces(dt);
    const VehicleState k1 = derivative(state_);
    const VehicleState k2 = derivative(moved(state_, k1, 0.5 * dt));
    const VehicleState k3 = derivative(moved(state_, k2, 0.5 * dt));
    const VehicleState k4 = derivative(moved(state_, k3, dt));
    const VehicleState sum = moved(moved(moved(k1, k2, 2.0), k3, 2.0), k4, 1.0);
    state_ = moved(state_, sum, dt / 6.0);
    state_.q_NB = math::normalized(state_.q_NB);
    ground_.settle(motion_of(state_));
}

Wrench Plant::add_propellers(const AirMotion& motion, const VehicleState& state,
                             PropellerSpeeds& rates) const {
    Wrench sum;
    const double supplied = math::square(influence_.supply);
    for (unsigned i = 0; i < parameters_.propellers.size(); ++i) {
        const PropellerOutput made =
            turn(parameters_.propellers[i],
                 {.velocity_B = motion.velocity_B,
                  .rate_B = motion.rate_B,
                  .air_density = influence_.air_density,
                  .speed = state.propeller_speeds[i],
                  .shaft_power = supplied * shaft_powers_[i],
                  .efficiency = influence_.efficiency[parameters_.rotor_count() + i]});
        sum = sum + made.wrench;
        rates[i] = made.speed_rate;
    }
    return sum;
}

Wrench Plant::applied_wrench(const Motion& motion, const VehicleState& state,
                             PropellerSpeeds& propeller_rates) const {
    const AirMotion in_air{motion.R_NB.transpose() * (motion.velocity_N - influence_.wind_N),
                           motion.rate_B};
    const double air_density = influence_.air_density;
    Wrench sum = body_drag(parameters_, in_air.velocity_B, air_density) + ground_.wrench(motion);
    for (unsigned i = 0; i < parameters_.rotor_count(); ++i) {
        const double efficiency = parameters_.rotors[i].in_wake * influence_.efficiency[i];
        sum = sum + rotor_wrench(parameters_, i, in_air, state.rotor_speeds[i], efficiency);
    }
    if (parameters_.has_wing()) {
        sum = sum + wing_wrench(parameters_.wing, deflections_, in_air.velocity_B, in_air.rate_B,
                                air_density);
    }
    if (!parameters_.propellers.empty()) {
        sum = sum + add_propellers(in_air, state, propeller_rates);
    }
    return sum;
}

VehicleState Plant::derivative(const VehicleState& state) const {
    const Motion motion = motion_of(state);
    VehicleState rate;
    const Wrench wrench = applied_wrench(motion, state, rate.propeller_speeds);
    rate.rotor_speeds = lag(parameters_, influence_.supply * commanded_speeds_, state.rotor_speeds);
    rate.position_N = state.velocity_N;
    if (influence_.carried_N) {
        rate.velocity_N = *influence_.carried_N;
        rate.q_NB = Quaternion(0.0, 0.0, 0.0, 0.0);
        return rate;
    }
    const Vector3 gravity_N(0.0, 0.0, parameters_.gravity);
    const Vector3 momentum_B = parameters_.inertia.times(state.rate_B);
    const Vector3 torque_B = wrench.torque_B - state.rate_B.cross(momentum_B);
    const Vector3 half_rate_B = 0.5 * state.rate_B;
    const Quaternion turning(0.0, half_rate_B.x(), half_rate_B.y(), half_rate_B.z());
    rate.velocity_N = motion.R_NB * wrench.force_B / parameters_.mass + gravity_N;
    rate.q_NB = state.q_NB * turning;
    rate.rate_B = parameters_.inertia.solve(torque_B);
    return rate;
}

Vector3 Plant::specific_force_B() const {
    const Motion motion = motion_of(state_);
    if (influence_.carried_N) {
        return motion.R_NB.transpose() *
               (*influence_.carried_N - Vector3(0.0, 0.0, parameters_.gravity));
    }
    PropellerSpeeds unused;
    return applied_wrench(motion, state_, unused).force_B / parameters_.mass;
}

Vector3 Plant::velocity_in_air_B() const {
    return state_.q_NB.toRotationMatrix().transpose() * (state_.velocity_N - influence_.wind_N);
}

double Plant::lift_over_weight() const {
    return parameters_.thrust_per_speed2 *
           sum_of_squares(state_.rotor_speeds, 0, parameters_.rotor_count()) /
           (parameters_.mass * parameters_.gravity);
}

// Of rotors, the mean (speed / speed in hover)^2, and of propellers, their thrust over the weight.
double Plant::mean_load() const {
    const double weight = parameters_.mass * parameters_.gravity;
    const unsigned rotors = parameters_.rotor_count();
    double sum = 0.0;
    for (unsigned i = 0; i < rotors; ++i) {
        sum += parameters_.thrust_per_speed2 * state_.rotor_speeds[i] * state_.rotor_speeds[i] /
               (weight / rotors);
    }
    if (rotors != 0) sum /= rotors;
    for (unsigned i = 0; i < parameters_.propellers.size(); ++i) {
        sum += static_thrust(parameters_.propellers[i], state_.propeller_speeds[i]) / weight;
    }
    return sum;
}

double Plant::electric_power() const {
    double sum = 0.0;  // of thrust to the power of 3/2
    for (unsigned i = 0; i < parameters_.rotor_count(); ++i) {
        const double speed = state_.rotor_speeds[i];
        const double thrust = parameters_.thrust_per_speed2 * speed * speed;
        sum += thrust * math::sqrt(thrust);
    }
    const double induced = sum / math::sqrt(2.0 * influence_.air_density * parameters_.disc_area);
    double power = induced / parameters_.power_efficiency + parameters_.avionics_power;
    for (unsigned i = 0; i < parameters_.propellers.size(); ++i) {
        const double shaft = math::square(influence_.supply) * shaft_powers_[i];
        power += math::max(shaft, 0.0) / parameters_.propellers[i].efficiency;
    }
    return power;
}

}  // namespace stator::world
