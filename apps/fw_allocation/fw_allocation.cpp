// Control allocation of an aeroplane.
#include "fw_allocation.hpp"

#include <algorithm>

namespace stator::apps::fw_allocation {

using math::Vector3;

namespace {

// Without a torque for so long, a status alone stops the motors.
constexpr uint64_t kSilent_us = 20'000;

std::array<Vector3<float>, kMaxSurfaces> effectiveness_of(const FwAllocationParams& p) {
    return {{Vector3<float>{p.surface0_roll, p.surface0_pitch, p.surface0_yaw},
             Vector3<float>{p.surface1_roll, p.surface1_pitch, p.surface1_yaw},
             Vector3<float>{p.surface2_roll, p.surface2_pitch, p.surface2_yaw},
             Vector3<float>{p.surface3_roll, p.surface3_pitch, p.surface3_yaw},
             Vector3<float>{p.surface4_roll, p.surface4_pitch, p.surface4_yaw},
             Vector3<float>{p.surface5_roll, p.surface5_pitch, p.surface5_yaw},
             Vector3<float>{p.surface6_roll, p.surface6_pitch, p.surface6_yaw},
             Vector3<float>{p.surface7_roll, p.surface7_pitch, p.surface7_yaw}}};
}

float share_or_zero(float value, float least, float most) {
    return math::is_nan(value) ? 0.0F : math::clamp(value, least, most);
}

}  // namespace

void FwAllocation::step(FwAllocationPorts& ports) {
    if (ports.params.is_new()) {
        const auto count = static_cast<unsigned>(ports.params->surface_count);
        const auto all = effectiveness_of(*ports.params);
        surfaces_.set_effectiveness(std::span(all).first(std::min(count, kMaxSurfaces)));
        motor_count_ = static_cast<unsigned>(ports.params->motor_count);
    }
    if (ports.status) is_armed_ = ports.status->arming_state == VehicleStatus::ArmingState::kArmed;
    if (ports.torque) torque_us_ = ports.now;
    const bool is_silent = torque_us_ != 0 && ports.now >= torque_us_ + kSilent_us;
    if (!ports.torque && (is_armed_ || !is_silent)) return;

    ActuatorServos servos{.timestamp_sample = ports.now};
    ActuatorMotors motors{.timestamp_sample = ports.now};
    servos.control.fill(math::canonical_nan<float>());
    motors.control.fill(math::canonical_nan<float>());
    if (ports.torque) servos.timestamp_sample = ports.torque->timestamp_sample;
    motors.timestamp_sample = servos.timestamp_sample;
    if (is_armed_) {
        const auto& xyz = ports.torque->xyz;
        surfaces_.allocate({share_or_zero(xyz[0], -1.0F, 1.0F), share_or_zero(xyz[1], -1.0F, 1.0F),
                            share_or_zero(xyz[2], -1.0F, 1.0F)},
                           servos.control);
        const float thrust = ports.thrust ? share_or_zero(ports.thrust->xyz[0], 0.0F, 1.0F) : 0.0F;
        const auto end =
            motors.control.begin() + std::min<std::size_t>(motor_count_, motors.control.size());
        std::fill(motors.control.begin(), end, thrust);
    }
    ports.servos.publish([&] { return servos; });
    ports.motors.publish([&] { return motors; });
}

}  // namespace stator::apps::fw_allocation
