// A simulated pitot tube.
#include "world/pitot.hpp"

namespace stator::world {

Pitot::Pitot(const PitotParameters& parameters, const Earth& earth, std::uint64_t seed)
    : parameters_(parameters),
      earth_(earth),
      random_(seed, stream_of("airspeed")),
      offset_(parameters.offset * random_.gaussian_double()),
      scale_(1.0 + parameters.scale * random_.gaussian_double()),
      drift_(Vector3(parameters.drift, 0.0, 0.0), parameters.drift_tau,
             static_cast<double>(parameters.period_us) * 1e-6, random_) {}

Pitot::Ports Pitot::ports(const Plant& plant) const {
    const Vector3 velocity_B = plant.velocity_in_air_B();
    const double ahead = velocity_B.x() / parameters_.straight;
    const double speed2 = math::min(ahead * ahead, velocity_B.squaredNorm());
    const double ram = 0.5 * plant.influence().air_density * speed2;
    return {.ram = ahead < 0.0 ? -ram : ram,
            .static_pressure = earth_.pressure(-plant.state().position_N.z())};
}

PitotSample Pitot::measure(const Plant& plant, const Faults& faults) {
    const double noise = parameters_.noise * random_.gaussian_double();
    const double drift = drift_.next(random_).x();
    const std::uint64_t now_us = plant.time_us();
    const Ports open = ports(plant);
    const bool is_trapped = faults.now(FaultKind::kPitotTrapped, now_us).has_value();
    const bool is_static_blocked = faults.now(FaultKind::kStaticBlocked, now_us).has_value();
    if (!is_trapped && !is_static_blocked) sealed_ = open;
    double total = open.ram + open.static_pressure;
    if (is_trapped) total = sealed_.ram + sealed_.static_pressure;
    // An open drain lets the pressure around into the tube.
    if (faults.now(FaultKind::kPitotBlocked, now_us)) total = open.static_pressure;
    double pressure = total - (is_static_blocked ? sealed_.static_pressure : open.static_pressure);
    for (const Fault& fault : faults) {
        if (fault.kind != FaultKind::kIce || !fault.acts(now_us)) continue;
        const double since = static_cast<double>(now_us - fault.from_us) * 1e-6;
        pressure *= math::square(math::max(1.0 - since / fault.value, 0.0));
    }
    const double measured = scale_ * pressure + offset_ + drift + noise;
    return {.pressure =
                static_cast<float>(math::round(measured * parameters_.steps) / parameters_.steps),
            .temperature_degc =
                static_cast<float>(earth_.temperature_degc(-plant.state().position_N.z()) +
                                   parameters_.warmer_by_degc)};
}

}  // namespace stator::world
