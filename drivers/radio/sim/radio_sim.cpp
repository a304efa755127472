// The radio receiver of a simulated board.
#include "radio_sim.hpp"

namespace stator::drivers::radio::sim {

void RadioSim::step(RadioPorts& ports) {
    if (!ports.fired.received) return;
    using Switches = ManualControlSwitches;
    const Device frame = device_;
    ports.switches.publish([&] {
        return Switches{
            .timestamp_sample = frame.timestamp_sample,
            .mode_slot = static_cast<uint8_t>(frame.mode_slot),
            .arm_switch = frame.arm ? Switches::ArmSwitch::kOn : Switches::ArmSwitch::kOff,
            .return_switch =
                frame.return_home ? Switches::ReturnSwitch::kOn : Switches::ReturnSwitch::kOff,
            .kill_switch = frame.kill ? Switches::KillSwitch::kOn : Switches::KillSwitch::kOff};
    });
    ports.sticks.publish([&] {
        return ManualControlSetpoint{.timestamp_sample = frame.timestamp_sample,
                                     .valid = frame.is_heard,
                                     .roll = frame.roll,
                                     .pitch = frame.pitch,
                                     .yaw = frame.yaw,
                                     .throttle = frame.throttle};
    });
}

}  // namespace stator::drivers::radio::sim
