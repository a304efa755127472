// The battery monitor of a simulated board.
#include "battery_sim.hpp"

namespace stator::drivers::battery::sim {

namespace {

using Warning = BatteryStatus::Warning;

Warning warning(float remaining, const BatteryParams& params) {
    if (remaining < params.emergency) return Warning::kEmergency;
    if (remaining < params.critical) return Warning::kCritical;
    if (remaining < params.low) return Warning::kLow;
    return Warning::kNone;
}

}  // namespace

void BatterySim::step(BatteryPorts& ports) {
    if (device_.refresh != nullptr) device_.refresh(device_);
    const Device battery = device_;
    const bool connected = battery.voltage_v > 0.0F;
    ports.status.publish([&] {
        return BatteryStatus{
            .connected = connected,
            .voltage_v = battery.voltage_v,
            .current_a = battery.current_a,
            .discharged_mah = battery.discharged_mah,
            .remaining = battery.remaining,
            .warning = connected ? warning(battery.remaining, *ports.params) : Warning::kNone};
    });
}

}  // namespace stator::drivers::battery::sim
