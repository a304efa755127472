// Calibrates the inertial sensors, the magnetometer and the horizon on request.
#pragma once

#include <array>
#include <string_view>

#include "calibration_ports.hpp"
#include "six_sides.hpp"
#include "sphere_fit.hpp"
#include "still.hpp"

namespace stator::apps::calibration {

// One calibration at a time, while disarmed. Samples arrive with the calibration that counts; it is
// taken out of them first, so that each result stands alone. Results become parameters, one after
// the other, and count together once the last one is set: only then the drivers are told.
//
//   gyro   the mean of 5 s at rest
//   accel  0.5 s at rest on each of six sides: offset and factor of each axis
//   mag    turned about all axes until the field was seen from each side: a sphere's centre
//   level  2 s at rest, level: how the sensors are turned in the vehicle
class Calibration {
  public:
    void step(CalibrationPorts& ports);

  private:
    using Action = CalibrationRequest::Action;
    static constexpr unsigned kMostResults = 7;

    struct Result {
        std::string_view id;
        bool is_whole = false;
        float value = 0.0F;
    };

    void take_request(CalibrationPorts& ports);
    void begin(Action action, CalibrationPorts& ports);
    void end(CalibrationPorts& ports);
    void fail(std::string_view why, CalibrationPorts& ports);
    void measure_gyro(CalibrationPorts& ports);
    void measure_accel(CalibrationPorts& ports);
    void measure_mag(CalibrationPorts& ports);
    void measure_level(CalibrationPorts& ports);
    void take_side(Side side, CalibrationPorts& ports);
    void keep(std::string_view id, float value);
    void set_next(CalibrationPorts& ports);
    void say(std::string_view text, CalibrationPorts& ports,
             StatusText::Severity severity = StatusText::Severity::kInfo);
    void say_progress(unsigned percent, CalibrationPorts& ports);
    void configure(CalibrationPorts& ports);
    void tell_drivers(CalibrationPorts& ports);

    Vector gyro_offset_ = Vector::Zero();
    Vector accel_offset_ = Vector::Zero();
    Vector accel_scale_ = Vector::Ones();
    Vector mag_offset_ = Vector::Zero();
    math::Matrix3<float> rotation_ = math::Matrix3<float>::Identity();

    Action running_ = Action::kCancel;  // cancel: none
    uint64_t begun_us_ = 0;
    unsigned percent_ = 0;  // that was said
    Still still_{0.0F};
    Still turning_{0.0F};  // of the gyro, where the other one is not
    SixSides sides_;
    unsigned told_side_ = kSides;  // that was found last
    SphereFit sphere_;
    std::array<Result, kMostResults> results_{};
    unsigned result_count_ = 0;
    unsigned set_count_ = 0;
    bool is_asking_ = false;
    uint64_t asked_us_ = 0;
    uint8_t tag_ = 0;
    bool is_told_ = false;  // the drivers know what counts
};

}  // namespace stator::apps::calibration
