// The simulated battery.
#include "world/battery.hpp"

#include "stator/scalar.hpp"

namespace stator::world {

double open_circuit_voltage(double remaining) {
    const double s = remaining;
    return -1.031 * math::exp(-35.0 * s) + 3.685 + s * (0.2156 + s * (-0.1178 + s * 0.3201));
}

Battery::Battery(const BatteryParameters& parameters)
    : parameters_(parameters), voltage_(parameters.cells * open_circuit_voltage(1.0)) {}

void Battery::draw(double power, double seconds) {
    const double open = parameters_.cells * open_circuit_voltage(remaining_);
    // The larger root of V^2 - open V + R P = 0; a battery gives no more than at half its voltage.
    const double discriminant = open * open - 4.0 * parameters_.resistance * power;
    voltage_ = 0.5 * (open + math::sqrt(math::max(discriminant, 0.0)));
    current_ = (open - voltage_) / parameters_.resistance;
    limit(remaining_ - current_ * seconds / parameters_.capacity_c);
}

void Battery::limit(double remaining) {
    remaining_ = math::clamp(remaining, 0.0, remaining_);
}

}  // namespace stator::world
