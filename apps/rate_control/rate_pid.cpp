// PID control of the three body rates.
#include "rate_pid.hpp"

namespace stator::apps::rate_control {

using math::Vector3;

namespace {

constexpr float kTorqueLimit = 1.0F;
constexpr float kButterworthDamping = 0x1.6a09e6p+0F;  // sqrt(2) = 1/Q

}  // namespace

// Butterworth low pass as a state-variable filter of trapezoidal integrators (Zavalishin: The Art
// of VA Filter Design, 2018, chapter 4). Its coefficients follow from this step's dt without a
// tangent or a past dt, it is stable for every dt, and its band-pass output is the wanted
// derivative over the cutoff.
Vector3<float> RatePid::filtered_derivative(const Vector3<float>& rate, float dt) {
    if (!started_) low_ = rate;
    started_ = true;
    const float g = 0.5F * gains_.derivative_cutoff * dt;
    const float feedback = 1.0F / (1.0F + g * (g + kButterworthDamping));
    const Vector3<float> band = feedback * (band_ + g * (rate - low_));
    const Vector3<float> low = low_ + g * band;
    band_ = 2.0F * band - band_;
    low_ = 2.0F * low - low_;
    return gains_.derivative_cutoff * band;
}

Vector3<float> RatePid::update(const Vector3<float>& rate, const Vector3<float>& setpoint, float dt,
                               bool integrate) {
    const Vector3<float> error = setpoint - rate;
    const Vector3<float> derivative = filtered_derivative(rate, dt);
    Vector3<float> torque;
    for (int axis = 0; axis < 3; ++axis) {
        const float wanted =
            gains_.p[axis] * error[axis] + integral_[axis] - gains_.d[axis] * derivative[axis];
        torque[axis] = math::clamp(wanted, -kTorqueLimit, kTorqueLimit);
        const bool winds_up = (wanted - torque[axis]) * error[axis] > 0.0F;
        if (!integrate || winds_up) continue;
        const float grown = integral_[axis] + gains_.i[axis] * error[axis] * dt;
        integral_[axis] = math::clamp(grown, -gains_.integral_limit, gains_.integral_limit);
    }
    return torque;
}

}  // namespace stator::apps::rate_control
