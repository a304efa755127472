// Control allocation: from torque and thrust to one command for each motor.
#include "allocation.hpp"

namespace stator::apps::allocation {

using math::Vector3;

namespace {

std::array<Rotor, kMaxRotors> rotors_of(const AllocationParams& p) {
    return {{{p.rotor0_x, p.rotor0_y, p.rotor0_moment},
             {p.rotor1_x, p.rotor1_y, p.rotor1_moment},
             {p.rotor2_x, p.rotor2_y, p.rotor2_moment},
             {p.rotor3_x, p.rotor3_y, p.rotor3_moment},
             {p.rotor4_x, p.rotor4_y, p.rotor4_moment},
             {p.rotor5_x, p.rotor5_y, p.rotor5_moment},
             {p.rotor6_x, p.rotor6_y, p.rotor6_moment},
             {p.rotor7_x, p.rotor7_y, p.rotor7_moment},
             {p.rotor8_x, p.rotor8_y, p.rotor8_moment},
             {p.rotor9_x, p.rotor9_y, p.rotor9_moment},
             {p.rotor10_x, p.rotor10_y, p.rotor10_moment},
             {p.rotor11_x, p.rotor11_y, p.rotor11_moment}}};
}

// The number of rotors that can be flown with: all of them or none.
unsigned configure(Rotors& rotors, const AllocationParams& params) {
    const auto count = static_cast<unsigned>(params.rotor_count);
    if (count > kMaxRotors) return 0;
    const std::array<Rotor, kMaxRotors> all = rotors_of(params);
    rotors.set_range(params.idle, params.airmode);
    return rotors.set_geometry(std::span(all).first(count)) ? count : 0;
}

// Without a torque for so long, a status alone stops the motors.
constexpr uint64_t kSilent_us = 20'000;
constexpr uint64_t kTest_us = 100'000;

float share_or_zero(float value, float least, float most) {
    return math::is_nan(value) ? 0.0F : math::clamp(value, least, most);
}

}  // namespace

void Allocation::test_motor(const AllocationPorts& ports, std::span<float> control) const {
    if (!ports.test || ports.test->motor >= count_) return;
    const bool is_over = ports.now > ports.test->timestamp + kTest_us;
    if (is_over || math::is_nan(ports.test->thrust)) return;
    control[ports.test->motor] = math::clamp(ports.test->thrust, 0.0F, 1.0F);
}

void Allocation::step(AllocationPorts& ports) {
    if (ports.params.is_new()) {
        count_ = configure(rotors_, *ports.params);
        ports.allocation.publish(
            [&] { return AllocationStatus{.motor_count = static_cast<uint8_t>(count_)}; });
    }
    if (ports.status) is_armed_ = ports.status->arming_state == VehicleStatus::ArmingState::kArmed;
    if (ports.torque) torque_us_ = ports.now;
    const bool is_silent = torque_us_ != 0 && ports.now >= torque_us_ + kSilent_us;
    if (!ports.torque && (is_armed_ || !is_silent)) return;

    std::array<float, kMaxRotors> control;
    control.fill(math::canonical_nan<float>());
    if (is_armed_ && count_ != 0) {
        const auto& xyz = ports.torque->xyz;
        const Vector3<float> torque(share_or_zero(xyz[0], -1.0F, 1.0F),
                                    share_or_zero(xyz[1], -1.0F, 1.0F),
                                    share_or_zero(xyz[2], -1.0F, 1.0F));
        const float up = ports.thrust ? share_or_zero(-ports.thrust->xyz[2], 0.0F, 1.0F) : 0.0F;
        rotors_.allocate(torque, up, control);
        if (ports.motors_left) control = ports.motors_left->control;
    }
    if (!is_armed_) test_motor(ports, control);
    ports.motors.publish([&] {
        return ActuatorMotors{
            .timestamp_sample = ports.torque ? ports.torque->timestamp_sample : ports.now,
            .control = control};
    });
}

}  // namespace stator::apps::allocation
