// Stands for a vehicle: a motor command and a status that do not change.
#pragma once

#include "stator/scalar.hpp"
#include "throttle_ports.hpp"

namespace stator::apps::throttle {

struct Throttle {
    void step(ThrottlePorts& ports) {
        ports.status.publish([&] {
            using State = VehicleStatus::ArmingState;
            return VehicleStatus{.arming_state =
                                     ports.params->armed ? State::kArmed : State::kDisarmed};
        });
        ports.motors.publish([&] {
            ActuatorMotors motors{.timestamp_sample = ports.now};
            motors.control.fill(math::canonical_nan<float>());
            for (unsigned i = 0; i < 4; ++i) motors.control[i] = ports.params->control;
            return motors;
        });
    }
};

}  // namespace stator::apps::throttle
