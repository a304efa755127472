// Body-rate control, the innermost loop.
#include "rate_control.hpp"

#include "stator/elapsed.hpp"

namespace stator::apps::rate_control {

using math::Vector3;

namespace {

// Between gyro samples; a gap or a repeated time stamp must not turn into a kick.
constexpr float kShortestStep = 125e-6F;
constexpr float kLongestStep = 20e-3F;

Vector3<float> finite_or_zero(const Vector3<float>& v) {
    return math::is_finite(v.sum()) ? v : Vector3<float>::Zero();
}

RateGains gains_of(const RateControlParams& params) {
    return {.p = {params.roll_p, params.pitch_p, params.yaw_p},
            .i = {params.roll_i, params.pitch_i, params.yaw_i},
            .d = {params.roll_d, params.pitch_d, params.yaw_d},
            .integral_limit = params.integral_limit,
            .derivative_cutoff = math::kTwoPi<float> * params.derivative_cutoff};
}

}  // namespace

void RateControl::take_setpoint(const VehicleRatesSetpoint& setpoint) {
    setpoint_ = finite_or_zero({setpoint.roll, setpoint.pitch, setpoint.yaw});
    thrust_ = finite_or_zero(math::vector(setpoint.thrust_body));
}

// While the vehicle stands on the ground, which holds it, an integral would only wind up.
bool RateControl::may_integrate(const RateControlPorts& ports) {
    const bool disarmed =
        ports.status && ports.status->arming_state != VehicleStatus::ArmingState::kArmed;
    if (disarmed) pid_.reset_integral();
    return !disarmed && -thrust_.z() >= integrate_from_;
}

void RateControl::step(RateControlPorts& ports) {
    if (!ports.gyro) return;
    if (ports.params.is_new()) {
        pid_.set_gains(gains_of(*ports.params));
        integrate_from_ = ports.params->integrate_from;
    }
    const Vector3<float> rate = math::vector(ports.gyro->xyz);
    if (!math::is_finite(rate.sum())) return;
    if (ports.setpoint) {
        take_setpoint(*ports.setpoint);
    } else {
        setpoint_.setZero();
    }

    const float dt = seconds_since_last(last_sample_us_, ports.gyro->timestamp_sample,
                                        kShortestStep, kLongestStep);
    const bool integrate = may_integrate(ports);
    const Vector3<float> torque = pid_.update(rate, setpoint_, dt, integrate);

    const uint64_t timestamp_sample = ports.gyro->timestamp_sample;
    // Torque activates allocation, so thrust goes first.
    ports.thrust.publish([&] {
        return VehicleThrustSetpoint{.timestamp_sample = timestamp_sample,
                                     .xyz = math::to_array(thrust_)};
    });
    ports.torque.publish([&] {
        return VehicleTorqueSetpoint{.timestamp_sample = timestamp_sample,
                                     .xyz = math::to_array(torque)};
    });
}

}  // namespace stator::apps::rate_control
