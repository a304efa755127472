// Calibrates the inertial sensors, the magnetometer and the horizon on request.
#include "calibration.hpp"

#include <algorithm>

#include "stator/scalar.hpp"

namespace stator::apps::calibration {

namespace {

using Severity = StatusText::Severity;

constexpr uint64_t kLongest_us = 120'000'000;  // of a whole calibration
constexpr uint64_t kPatience_us = 1'000'000;   // until a parameter is set
// At rest, at 100 Hz: how far a sample may be from the first one. Six sigma of the parts' noise.
constexpr float kGyroTolerance = 0.05F;  // rad/s
constexpr float kAccelTolerance = 0.8F;  // m/s^2
constexpr unsigned kGyroSamples = 500;
constexpr unsigned kSideSamples = 100;
constexpr unsigned kSettleSamples = 50;  // before a side counts
constexpr unsigned kLevelSamples = 200;
// Results beyond are not of a sound part.
constexpr float kMostGyroOffset = 0.4F;
constexpr float kMostAccelOffset = 3.0F;
constexpr float kMostAccelScale = 0.1F;  // from 1
constexpr float kMostTilt = 0.26F;       // 15 deg
constexpr float kMostMagOffset = 2.5F;
constexpr float kMostMagError = 0.05F;  // of the radius, rms
constexpr float kEnoughCoverage = 0.85F;

std::string_view name_of(CalibrationRequest::Action action) {
    switch (action) {
        case CalibrationRequest::Action::kGyro:
            return "gyro";
        case CalibrationRequest::Action::kAccel:
            return "accel";
        case CalibrationRequest::Action::kMag:
            return "mag";
        case CalibrationRequest::Action::kLevel:
        default:
            return "level";
    }
}

// A text of the form that ground stations read.
class Words {
  public:
    explicit Words(std::string_view begin) { *this << begin; }
    Words& operator<<(std::string_view words) {
        const std::size_t count = std::min(words.size(), text_.size() - size_);
        std::copy_n(words.begin(), count, text_.begin() + static_cast<std::ptrdiff_t>(size_));
        size_ += count;
        return *this;
    }
    Words& operator<<(unsigned number) {  // below 1000
        std::array<char, 3> digits{};
        std::size_t at = digits.size();
        do digits[--at] = static_cast<char>('0' + number % 10);
        while ((number /= 10) != 0 && at != 0);
        return *this << std::string_view(digits.data() + at, digits.size() - at);
    }
    std::string_view text() const { return {text_.data(), size_}; }

  private:
    std::array<char, 50> text_{};
    std::size_t size_ = 0;
};

template <class Sample>
bool is_finite(const Sample& sample) {
    return math::is_finite(sample.xyz[0]) && math::is_finite(sample.xyz[1]) &&
           math::is_finite(sample.xyz[2]);
}

bool is_within(const Vector& v, float most) {
    return math::abs(v.x()) <= most && math::abs(v.y()) <= most && math::abs(v.z()) <= most;
}

std::array<float, 9> rows_of(const math::Matrix3<float>& m) {
    return {m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2)};
}

}  // namespace

void Calibration::step(CalibrationPorts& ports) {
    if (ports.params.is_new() && result_count_ == 0) configure(ports);
    if (!is_told_) tell_drivers(ports);
    take_request(ports);
    if (running_ == Action::kCancel) return;
    const bool is_disarmed =
        ports.status && ports.status->arming_state == VehicleStatus::ArmingState::kDisarmed;
    if (!is_disarmed) {
        say("[cal] calibration cancelled", ports, Severity::kWarning);
        return end(ports);
    }
    if (result_count_ != 0) return set_next(ports);
    if (ports.now - begun_us_ > kLongest_us) return fail("it took too long", ports);
    switch (running_) {
        case Action::kGyro:
            return measure_gyro(ports);
        case Action::kAccel:
            return measure_accel(ports);
        case Action::kMag:
            return measure_mag(ports);
        case Action::kLevel:
        default:
            return measure_level(ports);
    }
}

void Calibration::configure(CalibrationPorts& ports) {
    const CalibrationParams& p = *ports.params;
    gyro_offset_ = Vector(p.gyro_offset_x, p.gyro_offset_y, p.gyro_offset_z);
    accel_offset_ = Vector(p.accel_offset_x, p.accel_offset_y, p.accel_offset_z);
    accel_scale_ = Vector(p.accel_scale_x, p.accel_scale_y, p.accel_scale_z);
    mag_offset_ = Vector(p.mag_offset_x, p.mag_offset_y, p.mag_offset_z);
    rotation_ = math::from_euler(math::EulerAngles<float>{p.level_roll, p.level_pitch, 0.0F})
                    .toRotationMatrix();
    is_told_ = false;
}

void Calibration::tell_drivers(CalibrationPorts& ports) {
    is_told_ = true;
    ports.imu.publish([&] {
        return ImuCalibration{.gyro_offset = math::to_array(gyro_offset_),
                              .accel_offset = math::to_array(accel_offset_),
                              .accel_scale = math::to_array(accel_scale_),
                              .rotation = rows_of(rotation_)};
    });
    ports.mag_calibration.publish([&] {
        return MagCalibration{.offset = math::to_array(mag_offset_),
                              .rotation = rows_of(rotation_)};
    });
}

// --- beginning and end ---

void Calibration::take_request(CalibrationPorts& ports) {
    while (ports.request.next()) {
        const Action action = ports.request->action;
        if (action == Action::kCancel) {
            if (running_ == Action::kCancel) continue;
            say("[cal] calibration cancelled", ports, Severity::kWarning);
            end(ports);
        } else if (running_ == Action::kCancel) {
            begin(action, ports);
        }
    }
}

void Calibration::begin(Action action, CalibrationPorts& ports) {
    running_ = action;
    begun_us_ = ports.now;
    percent_ = 0;
    still_ = Still(action == Action::kGyro ? kGyroTolerance : kAccelTolerance);
    turning_ = Still(kGyroTolerance);
    sides_.clear();
    told_side_ = kSides;
    sphere_.clear();
    const Words words = Words("[cal] calibration started: 2 ") << name_of(action);
    say(words.text(), ports);
    ports.running.publish([] { return CalibrationStatus{.is_running = true}; });
}

void Calibration::end(CalibrationPorts& ports) {
    running_ = Action::kCancel;
    // What was set of a result that is not whole counts as any parameter does.
    if (result_count_ != 0) configure(ports);
    result_count_ = 0;
    is_asking_ = false;
    ports.running.publish([] { return CalibrationStatus{.is_running = false}; });
}

void Calibration::fail(std::string_view why, CalibrationPorts& ports) {
    const Words words = Words("[cal] calibration failed: ") << why;
    say(words.text(), ports, Severity::kCritical);
    end(ports);
}

// --- measurements ---

void Calibration::measure_gyro(CalibrationPorts& ports) {
    if (!ports.gyro.is_new() || !is_finite(*ports.gyro)) return;
    const Vector sample = rotation_.transpose() * math::vector(ports.gyro->xyz);
    if (!still_.add(sample + gyro_offset_)) percent_ = 0;
    say_progress(100 * still_.count() / kGyroSamples, ports);
    if (still_.count() < kGyroSamples) return;
    const Vector offset = still_.mean();
    if (!is_within(offset, kMostGyroOffset)) return fail("the gyro turns by itself", ports);
    keep("CAL_GYRO0_XOFF", offset.x());
    keep("CAL_GYRO0_YOFF", offset.y());
    keep("CAL_GYRO0_ZOFF", offset.z());
    results_[result_count_++] = {.id = "CAL_GYRO0_ID", .is_whole = true, .value = 1.0F};
}

// The specific force as the part shows it.
void Calibration::measure_accel(CalibrationPorts& ports) {
    if (!ports.accel.is_new() || !is_finite(*ports.accel)) return;
    const Vector sample = rotation_.transpose() * math::vector(ports.accel->xyz);
    if (!still_.add(sample.cwiseQuotient(accel_scale_) + accel_offset_)) told_side_ = kSides;
    if (ports.gyro && !turning_.add(math::vector(ports.gyro->xyz))) still_.clear();
    if (still_.count() < kSettleSamples) return;
    Side side{};
    if (!SixSides::find(still_.mean(), side)) return;
    take_side(side, ports);
    if (sides_.count() < kSides) return;
    const SixSides::Result result = sides_.result();
    if (!is_within(result.offset, kMostAccelOffset) ||
        !is_within(result.scale - Vector::Ones(), kMostAccelScale)) {
        return fail("accelerometer far off", ports);
    }
    keep("CAL_ACC0_XOFF", result.offset.x());
    keep("CAL_ACC0_YOFF", result.offset.y());
    keep("CAL_ACC0_ZOFF", result.offset.z());
    keep("CAL_ACC0_XSCALE", result.scale.x());
    keep("CAL_ACC0_YSCALE", result.scale.y());
    keep("CAL_ACC0_ZSCALE", result.scale.z());
    results_[result_count_++] = {.id = "CAL_ACC0_ID", .is_whole = true, .value = 1.0F};
}

void Calibration::take_side(Side side, CalibrationPorts& ports) {
    const auto number = static_cast<unsigned>(side);
    const bool is_told = told_side_ == number;
    if (!is_told) {
        told_side_ = number;
        const Words words = Words("[cal] ") << calibration::name_of(side)
                                            << (sides_.has(side) ? " side already completed"
                                                                 : " orientation detected");
        return say(words.text(), ports);
    }
    if (sides_.has(side) || still_.count() < kSideSamples) return;
    sides_.put(side, still_.mean());
    percent_ = 0;
    say_progress(100 * sides_.count() / kSides, ports);
    const Words words = Words("[cal] ")
                        << calibration::name_of(side) << " side done, rotate to a different side";
    say(words.text(), ports);
}

void Calibration::measure_mag(CalibrationPorts& ports) {
    if (!ports.mag.is_new() || !is_finite(*ports.mag)) return;
    const Vector sample = rotation_.transpose() * math::vector(ports.mag->xyz);
    sphere_.add(sample + mag_offset_);
    const float coverage = sphere_.coverage() / kEnoughCoverage;
    say_progress(math::saturate<unsigned>(100.0F * math::min(coverage, 1.0F)), ports);
    if (coverage < 1.0F) return;
    const auto sphere = sphere_.fit();
    if (!sphere) return;  // more of it is needed
    if (!is_within(sphere->centre, kMostMagOffset)) return fail("the offset is large", ports);
    if (sphere->error > kMostMagError * sphere->radius)
        return fail("the field is disturbed", ports);
    keep("CAL_MAG0_XOFF", sphere->centre.x());
    keep("CAL_MAG0_YOFF", sphere->centre.y());
    keep("CAL_MAG0_ZOFF", sphere->centre.z());
    results_[result_count_++] = {.id = "CAL_MAG0_ID", .is_whole = true, .value = 1.0F};
}

// At rest and level, the specific force f points up: with f = |f| (sin p, -sin r cos p, -cos r cos
// p) the sensors are rolled by r and pitched by p.
void Calibration::measure_level(CalibrationPorts& ports) {
    if (!ports.accel.is_new() || !is_finite(*ports.accel)) return;
    const Vector force = rotation_.transpose() * math::vector(ports.accel->xyz);
    if (!still_.add(force)) percent_ = 0;
    say_progress(100 * still_.count() / kLevelSamples, ports);
    if (still_.count() < kLevelSamples) return;
    const Vector f = still_.mean();
    const float roll = math::atan2(-f.y(), -f.z());
    const float pitch = math::atan2(f.x(), math::sqrt(f.y() * f.y() + f.z() * f.z()));
    const bool is_level = math::abs(roll) <= kMostTilt && math::abs(pitch) <= kMostTilt;
    if (!is_level) return fail("it is not level", ports);
    keep("SENS_LEVEL_ROLL", roll);
    keep("SENS_LEVEL_PITCH", pitch);
}

// --- results ---

void Calibration::keep(std::string_view id, float value) {
    results_[result_count_++] = {.id = id, .value = value};
    set_count_ = 0;
}

void Calibration::set_next(CalibrationPorts& ports) {
    while (ports.value.next()) {
        const ParameterValue& value = *ports.value;
        const bool is_ours = is_asking_ && value.tag == tag_ &&
                             value.requester == ParameterValue::Requester::kCalibration;
        if (!is_ours) continue;
        is_asking_ = false;
        if (value.result != ParameterValue::Result::kWritten) {
            return fail("a parameter was refused", ports);
        }
        ++set_count_;
    }
    if (is_asking_) {
        if (ports.now - asked_us_ > kPatience_us) fail("parameters do not answer", ports);
        return;
    }
    if (set_count_ == result_count_) {
        const Words words = Words("[cal] calibration done: ") << name_of(running_);
        say(words.text(), ports);
        return end(ports);
    }
    const Result& result = results_[set_count_];
    is_asking_ = true;
    asked_us_ = ports.now;
    ++tag_;
    ports.set.publish([&] {
        ParameterRequest request{.requester = ParameterRequest::Requester::kCalibration,
                                 .tag = tag_,
                                 .action = ParameterRequest::Action::kSet,
                                 .type = ParameterRequest::Type::kFloat,
                                 .float_value = result.value};
        if (result.is_whole) {
            request.type = ParameterRequest::Type::kInt32;
            request.int_value = math::saturate<int32_t>(result.value);
        }
        std::copy(result.id.begin(), result.id.end(), request.name.begin());
        return request;
    });
}

// --- texts ---

void Calibration::say(std::string_view text, CalibrationPorts& ports, Severity severity) {
    ports.text.publish([&] {
        StatusText line{.severity = severity};
        std::copy(text.begin(), text.end(), line.text.begin());
        return line;
    });
}

// Each tenth once.
void Calibration::say_progress(unsigned percent, CalibrationPorts& ports) {
    if (percent < percent_ + 10 && percent != 100) return;
    if (percent == percent_) return;
    percent_ = percent;
    const Words words = Words("[cal] progress <") << percent << ">";
    say(words.text(), ports);
}

}  // namespace stator::apps::calibration
