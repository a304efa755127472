// Body-rate control of an aeroplane.
#include "fw_rate.hpp"

#include "stator/elapsed.hpp"

namespace stator::apps::fw_rate {

using math::Vector3;

namespace {

// Between gyro samples; a gap or a repeated time stamp must not turn into a kick.
constexpr float kShortestStep = 125e-6F;
constexpr float kLongestStep = 20e-3F;
constexpr float kTorqueLimit = 1.0F;
// Of the trim airspeed; beyond what is flown, so that a wrong airspeed changes the gains little.
constexpr float kSlowest = 0.4F;
constexpr float kFastest = 2.0F;

Vector3<float> finite_or_zero(const Vector3<float>& v) {
    return math::is_finite(v.sum()) ? v : Vector3<float>::Zero();
}

bool stands(const FwRatePorts& ports) {
    const bool disarmed =
        ports.status && ports.status->arming_state != VehicleStatus::ArmingState::kArmed;
    return disarmed || (ports.land && ports.land->landed);
}

// Slower than that it rolls on its wheels, which hold it.
bool flies(const FwRatePorts& ports) {
    return !ports.airspeed ||
           !(ports.airspeed->calibrated_airspeed_m_s < ports.params->stall_airspeed);
}

// Trim airspeed over airspeed.
float scale_of(const FwRatePorts& ports) {
    const FwRateParams& params = *ports.params;
    if (!ports.airspeed || !math::is_finite(ports.airspeed->calibrated_airspeed_m_s)) return 1.0F;
    const float trim = params.trim_airspeed;
    const float airspeed =
        math::clamp(ports.airspeed->calibrated_airspeed_m_s,
                    math::max(params.stall_airspeed, kSlowest * trim), kFastest * trim);
    return trim / airspeed;
}

}  // namespace

void FwRate::take_setpoint(const FwRatePorts& ports) {
    setpoint_.setZero();
    if (!ports.setpoint) return;
    const VehicleRatesSetpoint& setpoint = *ports.setpoint;
    setpoint_ = finite_or_zero({setpoint.roll, setpoint.pitch, setpoint.yaw});
    thrust_ = finite_or_zero(math::vector(setpoint.thrust_body));
}

Vector3<float> FwRate::torque(const Vector3<float>& rate, const FwRateParams& params, float scale,
                              float dt, bool integrate) {
    const Vector3<float> p(params.roll_p, params.pitch_p, params.yaw_p);
    const Vector3<float> i(params.roll_i, params.pitch_i, params.yaw_i);
    const Vector3<float> ff(params.roll_ff, params.pitch_ff, params.yaw_ff);
    const Vector3<float> error = setpoint_ - rate;
    Vector3<float> result;
    for (int axis = 0; axis < 3; ++axis) {
        const float wanted = scale * scale * (p[axis] * error[axis] + integral_[axis]) +
                             scale * ff[axis] * setpoint_[axis];
        result[axis] = math::clamp(wanted, -kTorqueLimit, kTorqueLimit);
        const bool winds_up = (wanted - result[axis]) * error[axis] > 0.0F;
        if (!integrate || winds_up) continue;
        integral_[axis] = math::clamp(integral_[axis] + i[axis] * error[axis] * dt,
                                      -params.integral_limit, params.integral_limit);
    }
    return result;
}

void FwRate::step(FwRatePorts& ports) {
    if (!ports.gyro) return;
    const Vector3<float> rate = math::vector(ports.gyro->xyz);
    if (!math::is_finite(rate.sum())) return;
    take_setpoint(ports);
    const uint64_t timestamp_sample = ports.gyro->timestamp_sample;
    const float dt =
        seconds_since_last(last_sample_us_, timestamp_sample, kShortestStep, kLongestStep);
    if (stands(ports)) integral_.setZero();
    const bool integrate = !stands(ports) && flies(ports);
    const Vector3<float> torque = this->torque(rate, *ports.params, scale_of(ports), dt, integrate);
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

}  // namespace stator::apps::fw_rate
