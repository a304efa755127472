// What the simulated sensors make of the truth.
#include "world/sensors.hpp"

namespace stator::world {

namespace {

// Components in order: the arguments of a constructor have none.
Vector3f gaussian3(math::Random& random, float sigma) {
    Vector3f result;
    for (float& component : result) component = sigma * random.gaussian_float();
    return result;
}

float quantised(float value, float steps) {
    const auto count = math::saturate<std::int16_t>(math::round(value * steps));
    return static_cast<float>(count) / steps;
}

Vector3f quantised(const Vector3f& value, float steps) {
    return {quantised(value.x(), steps), quantised(value.y(), steps), quantised(value.z(), steps)};
}

// Of one rotor against all in hover: (speed / hover speed)^2.
double load(const Airframe& parameters, double speed) {
    const double hover_thrust = parameters.mass * parameters.gravity / parameters.rotor_count();
    return parameters.thrust_per_speed2 * speed * speed / hover_thrust;
}

double drift_period(const ImuParameters& parameters) {
    return static_cast<double>(parameters.drift_samples * parameters.period_us) * 1e-6;
}

}  // namespace

Imu::Imu(const ImuParameters& parameters, unsigned rotors, std::uint64_t seed)
    : parameters_(parameters),
      random_(seed, static_cast<std::uint64_t>(Stream::kImu)),
      drift_random_(seed, static_cast<std::uint64_t>(Stream::kImuDrift)),
      gyro_bias_(gaussian3(random_, parameters.gyro_bias)),
      accel_bias_(gaussian3(random_, parameters.accel_bias)),
      gyro_per_degc_(parameters.gyro_per_degc * gaussian3(drift_random_)),
      accel_per_degc_(parameters.accel_per_degc * gaussian3(drift_random_)),
      gyro_wander_(Vector3::Constant(parameters.gyro_instability), parameters.instability_tau,
                   drift_period(parameters), drift_random_),
      accel_wander_(Vector3::Constant(parameters.accel_instability), parameters.instability_tau,
                    drift_period(parameters), drift_random_) {
    for (unsigned i = 0; i < rotors; ++i) {
        rotor_angles_[i] = math::kTwoPi<double> * random_.uniform_double() - math::kPi<double>;
    }
}

void Imu::drift() {
    const double age = static_cast<double>(samples_ * parameters_.period_us) * 1e-6;
    const double warmer =
        parameters_.warms_by_degc * (1.0 - math::exp(-age / parameters_.warming_tau));
    const Vector3 gyro = warmer * gyro_per_degc_ + gyro_wander_.next(drift_random_);
    const Vector3 accel = warmer * accel_per_degc_ + accel_wander_.next(drift_random_);
    gyro_offset_ = gyro_bias_ + gyro.cast<float>();
    accel_offset_ = accel_bias_ + accel.cast<float>();
}

// Imbalance pushes each rotor's hub round once a turn; its two blades pass an arm twice.
Vector3f Imu::rotor_lines(const Plant& plant) {
    const double period = static_cast<double>(parameters_.period_us) * 1e-6;
    Vector3f sum = Vector3f::Zero();
    for (unsigned i = 0; i < plant.parameters().rotor_count(); ++i) {
        const double speed = plant.state().rotor_speeds[i];
        if (speed <= 0.0) continue;
        rotor_angles_[i] = math::wrap_pi(rotor_angles_[i] + speed * period);
        const auto turn = math::sincos(static_cast<float>(rotor_angles_[i]));
        const float size = static_cast<float>(load(plant.parameters(), speed));
        sum += size * Vector3f(turn.cos, turn.sin, 2.0F * turn.sin * turn.cos);
    }
    return sum;
}

ImuSample Imu::measure(const Plant& plant) {
    if (samples_ % parameters_.drift_samples == 0) drift();
    ++samples_;
    const Vector3f lines = rotor_lines(plant);
    const float shaking = static_cast<float>(plant.mean_load());
    const float gyro_sigma = math::sqrt(math::square(parameters_.gyro_noise) +
                                        math::square(parameters_.gyro_shake * shaking));
    const float accel_sigma = math::sqrt(math::square(parameters_.accel_noise) +
                                         math::square(parameters_.accel_shake * shaking));
    const Vector3f gyro_noise = gaussian3(random_, gyro_sigma);
    const Vector3f accel_noise = gaussian3(random_, accel_sigma);
    const Vector3f gyro_B = plant.state().rate_B.cast<float>() + gyro_offset_ + gyro_noise +
                            parameters_.gyro_imbalance * lines;
    const Vector3f accel_B = plant.specific_force_B().cast<float>() + accel_offset_ + accel_noise +
                             parameters_.accel_imbalance * lines;
    return {quantised(gyro_B, parameters_.gyro_steps), quantised(accel_B, parameters_.accel_steps)};
}

Mocap::Mocap(const MocapParameters& parameters, std::uint64_t seed)
    : parameters_(parameters), random_(seed, static_cast<std::uint64_t>(Stream::kMocap)) {}

MocapSample Mocap::measure(const Plant& plant) {
    const VehicleState& state = plant.state();
    const Vector3f position_noise = gaussian3(random_, parameters_.position_noise);
    const float yaw_noise = parameters_.yaw_noise * random_.gaussian_float();
    return {.time_us = plant.time_us(),
            .position_N = state.position_N.cast<float>() + position_noise,
            .yaw = math::wrap_pi(static_cast<float>(math::heading(state.q_NB)) + yaw_noise)};
}

}  // namespace stator::world
