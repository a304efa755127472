// The simulated sensors that place a vehicle on Earth.
#include "world/navigation_sensors.hpp"

namespace stator::world {

namespace {

double seconds(std::uint64_t time_us) {
    return static_cast<double>(time_us) * 1e-6;
}

Vector3 direction(math::Random& random) {
    return math::normalized(gaussian3(random), Vector3(Vector3::UnitX()));
}

Vector3 level_direction(math::Random& random) {
    const auto turn = math::sincos(math::kTwoPi<double> * random.uniform_double());
    return {turn.cos, turn.sin, 0.0};
}

double quantised(double value, double steps) {
    return math::round(value * steps) / steps;
}

}  // namespace

Magnetometer::Magnetometer(const MagnetometerParameters& parameters, const Earth& earth,
                           std::uint64_t seed)
    : parameters_(parameters),
      random_(seed, static_cast<std::uint64_t>(Stream::kMagnetometer)),
      field_N_(earth.magnetic_field_N()),
      hard_iron_B_(parameters.hard_iron * gaussian3(random_)),
      per_amp_B_(parameters.gauss_per_amp * direction(random_)) {}

Vector3f Magnetometer::measure(const VehicleState& state, double current) {
    const Vector3 noise = parameters_.noise * gaussian3(random_);
    const Vector3 field_B = state.q_NB.toRotationMatrix().transpose() * field_N_;
    Vector3 measured = field_B + hard_iron_B_ + current * per_amp_B_ + noise;
    for (double& component : measured) component = quantised(component, parameters_.steps);
    return measured.cast<float>();
}

Barometer::Barometer(const BarometerParameters& parameters, const Earth& earth, std::uint64_t seed)
    : parameters_(parameters),
      earth_(earth),
      random_(seed, static_cast<std::uint64_t>(Stream::kBarometer)),
      offset_(parameters.offset * random_.gaussian_double()),
      drift_(Vector3(parameters.drift, 0.0, 0.0), parameters.drift_tau,
             seconds(parameters.period_us), random_) {}

BarometerSample Barometer::measure(const Plant& plant) {
    const double height = -plant.state().position_N.z();
    const double noise = parameters_.noise * random_.gaussian_double();
    const double drift = drift_.next(random_).x();
    const double dynamic_pressure =
        0.5 * plant.influence().air_density * plant.velocity_in_air_B().squaredNorm();
    const double pressure = earth_.pressure(height) + offset_ + drift + noise +
                            parameters_.ram * dynamic_pressure +
                            parameters_.wash * plant.lift_over_weight();
    return {.pressure = static_cast<float>(quantised(pressure, parameters_.steps)),
            .temperature_degc =
                static_cast<float>(earth_.temperature_degc(height) + parameters_.warmer_by_degc)};
}

GnssReceiver::GnssReceiver(const GnssParameters& parameters, const Earth& earth, std::uint64_t seed)
    : parameters_(parameters),
      earth_(earth),
      random_(seed, static_cast<std::uint64_t>(Stream::kGnss)),
      slow_(parameters.slow, parameters.slow_tau, seconds(parameters.period_us), random_),
      fast_(parameters.fast, parameters.fast_tau, seconds(parameters.period_us), random_),
      velocity_(parameters.velocity, parameters.velocity_tau, seconds(parameters.period_us),
                random_),
      pulled_towards_N_(level_direction(random_)) {}

GnssFix GnssReceiver::fix(const Plant& plant, const Vector3& position_N,
                          const Vector3& velocity_error) const {
    const Vector3 velocity_N = plant.state().velocity_N + velocity_error;
    const double horizontal = math::sqrt(parameters_.slow.head<2>().squaredNorm());
    return {.time_us = plant.time_us(),
            .place = earth_.geodetic(position_N),
            .velocity_N = velocity_N.cast<float>(),
            .horizontal_error = static_cast<float>(horizontal),
            .vertical_error = static_cast<float>(parameters_.slow.z()),
            .speed_error = static_cast<float>(2.0 * math::norm(parameters_.velocity)),
            .satellites = parameters_.satellites};
}

GnssReceiver::Sending GnssReceiver::measure(const Plant& plant, const GnssFault& fault) {
    const Vector3 slow = slow_.next(random_);
    const Vector3 fast = fast_.next(random_);
    const Vector3 velocity_error = velocity_.next(random_);
    const Vector3 position_N =
        plant.state().position_N + slow + fast + fault.glitch * pulled_towards_N_;
    const std::uint64_t span = parameters_.most_delay_us - parameters_.least_delay_us;
    const auto delay_ms =
        static_cast<std::uint64_t>(random_.uniform_double() * static_cast<double>(span / 1000 + 1));
    const bool arrives = random_.uniform_double() >= parameters_.loss;
    Sending result{.arrival_us = plant.time_us() + parameters_.least_delay_us + 1000 * delay_ms,
                   .arrives = arrives,
                   .fix = fix(plant, position_N, velocity_error)};
    if (fault.lost) result.fix = {.time_us = plant.time_us()};
    return result;
}

}  // namespace stator::world
