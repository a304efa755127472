// Each activation reads what the last transfer brought, and arms the next one.
#include "imu_mpu6000.hpp"

#include <cstdlib>

#include "../imu_calibration.hpp"

namespace stator::drivers::imu::mpu6000 {

namespace {

constexpr uint8_t kRead = 0x80;
constexpr uint8_t kSamples = 0x3B;    // acceleration, temperature, rate: 14 bytes
constexpr uint8_t kSampleBytes = 15;  // with the register
constexpr uint8_t kPower = 0x6B;      // PWR_MGMT_1
constexpr uint8_t kDeviceReset = 0x80;
constexpr uint8_t kSleep = 0x40;  // as after a reset
constexpr uint8_t kWhoAmI = 0x75;
constexpr uint8_t kIdentity = 0x68;

struct Setting {
    uint8_t reg;
    uint8_t value;
};
// Clock from the gyroscope, reset of the signal paths, the bus of the other kind off.
constexpr std::array kWakeSettings{Setting{kPower, 0x01}, Setting{0x68, 0x07}, Setting{0x6A, 0x11}};
constexpr std::array kSettings{
    Setting{0x6A, 0x10},  // USER_CTRL: no I2C
    Setting{0x1B, 0x18},  // GYRO_CONFIG: 2000 deg/s
    Setting{0x1C, 0x18},  // ACCEL_CONFIG: 16 g
    Setting{0x1A, 0x01},  // CONFIG: 188 Hz, 1 kHz
    Setting{0x19, 0x00},  // SMPLRT_DIV: each one
    Setting{0x37, 0x80},  // INT_PIN_CFG: low for 50 us
    Setting{0x38, 0x01},  // INT_ENABLE: data ready
};
constexpr float kRadPerLsb = 2000.0F / 32768.0F * 0.017453293F;
constexpr float kMeterPerS2PerLsb = 16.0F / 32768.0F * 9.80665F;

constexpr uint64_t kStart_us = 100'000;  // after a reset, and after waking up
constexpr uint64_t kRetry_us = 10'000;
constexpr uint64_t kGiveUp_us = 1'000'000;
constexpr unsigned kSamplesPerCheck = 100;  // one register each 0.1 s
constexpr unsigned kMaxEqual = 20;          // noise changes some bit of each sample
constexpr unsigned kMaxFailures = 10;
constexpr unsigned kMaxSilent = 100;

}  // namespace

void ImuMpu6000::read(Transfer& transfer, uint8_t reg, uint8_t count, bool is_fast) {
    transfer.bytes.fill(0);
    transfer.bytes[0] = reg | kRead;
    transfer.count = static_cast<uint8_t>(1 + count);
    transfer.is_fast = is_fast;
}

void ImuMpu6000::write(uint8_t reg, uint8_t value) {
    device_.first.bytes[0] = reg;
    device_.first.bytes[1] = value;
    device_.first.count = 2;
    device_.first.is_fast = false;
}

void ImuMpu6000::step(ImuPorts& ports) {
    if (device_.state.load() != Device::kIdle || ports.now < wait_us_) return;
    device_.second.count = 0;
    if (phase_ == Phase::kRun) {
        measure(ports);
    } else {
        start(ports.now);
    }
    if (device_.first.count != 0) device_.state.store(Device::kArmed);
}

// Leaves the first transfer empty where there is nothing to do yet.
void ImuMpu6000::start(uint64_t now_us) {
    device_.first.count = 0;
    switch (phase_) {
        case Phase::kReset:
            reset();
            break;
        case Phase::kStart:
            wait_us_ = now_us + kStart_us;
            retry_us_ = wait_us_ + kGiveUp_us;
            phase_ = Phase::kIdentify;
            break;
        case Phase::kIdentify:
            identify(now_us);
            break;
        case Phase::kSettle:
            wait_us_ = now_us + kStart_us;
            phase_ = Phase::kConfigure;
            break;
        case Phase::kWake:
        case Phase::kConfigure:
            write_next();
            break;
        case Phase::kRun:
            break;
    }
}

// The last reset may have been given up: what the part does now is not known.
void ImuMpu6000::reset() {
    ++device_.resets;
    write(kPower, kDeviceReset);
    device_.second.count = 0;
    phase_ = Phase::kStart;
    has_asked_ = false;
    next_write_ = checked_ = 0;
    samples_ = equal_ = failures_ = silent_ = 0;
    checks_ = false;
}

// Asks for both registers until they have what they have after a reset.
void ImuMpu6000::identify(uint64_t now_us) {
    const bool is_there = device_.first.bytes[1] == kIdentity && device_.second.bytes[1] == kSleep;
    if (has_asked_ && is_there) {
        phase_ = Phase::kWake;
        write_next();
        return;
    }
    if (now_us >= retry_us_) {
        phase_ = Phase::kReset;
    } else {
        read(device_.first, kWhoAmI, 1, false);
        read(device_.second, kPower, 1, false);
        wait_us_ = has_asked_ ? now_us + kRetry_us : now_us;
        has_asked_ = true;
    }
}

void ImuMpu6000::write_next() {
    const bool wakes = phase_ == Phase::kWake;
    const Setting setting = wakes ? kWakeSettings[next_write_] : kSettings[next_write_];
    write(setting.reg, setting.value);
    if (++next_write_ < (wakes ? kWakeSettings.size() : kSettings.size())) return;
    next_write_ = 0;
    phase_ = wakes ? Phase::kSettle : Phase::kRun;
}

void ImuMpu6000::measure(ImuPorts& ports) {
    if (device_.first.count == kSampleBytes) {
        if (checks_) compare();
        if (is_good()) {
            publish(ports);
        } else {
            ++device_.bad;
            ++failures_;
        }
        silent_ = device_.is_ready ? 0 : silent_ + 1;
        device_.missed_lines += device_.is_ready ? 0 : 1;
    }
    if (failures_ > kMaxFailures || silent_ > kMaxSilent) {
        reset();
        return;
    }
    read(device_.first, kSamples, kSampleBytes - 1, true);
    checks_ = ++samples_ % kSamplesPerCheck == 0;
    if (checks_) read(device_.second, kSettings[checked_].reg, 1, false);
}

// A part without power gives equal bits; one that hangs, equal samples.
bool ImuMpu6000::is_good() {
    const auto& bytes = device_.first.bytes;
    unsigned ones = 0xFF;
    unsigned zeros = 0x00;
    unsigned changes = 0x00;
    for (unsigned i = 1; i < bytes.size(); ++i) {
        ones &= bytes[i];
        zeros |= bytes[i];
        changes |= static_cast<unsigned>(bytes[i]) ^ last_[i];
    }
    equal_ = changes == 0 ? equal_ + 1 : 0;
    last_ = bytes;
    return ones != 0xFF && zeros != 0x00 && equal_ < kMaxEqual;
}

// A register that lost its value: the part lost its power, or was disturbed.
void ImuMpu6000::compare() {
    if (device_.second.bytes[1] == kSettings[checked_].value) {
        failures_ = 0;
    } else {
        failures_ = kMaxFailures + 1;
    }
    checked_ = static_cast<uint8_t>((checked_ + 1U) % kSettings.size());
}

void ImuMpu6000::publish(ImuPorts& ports) {
    const auto axes = [&](unsigned at, float scale) {
        std::array<float, 3> body{};
        for (unsigned i = 0; i < body.size(); ++i) {
            const int axis = device_.axes[i];
            const unsigned place = at + 2 * (static_cast<unsigned>(std::abs(axis)) - 1);
            const auto& bytes = device_.first.bytes;
            const auto raw = static_cast<int16_t>(bytes[place] << 8 | bytes[place + 1]);
            body[i] = static_cast<float>(axis < 0 ? -raw : raw) * scale;
        }
        return body;
    };
    const uint64_t time_us = device_.time_us;
    Xyz accel = axes(1, kMeterPerS2PerLsb);
    Xyz gyro = axes(9, kRadPerLsb);
    if (ports.calibration) {
        accel = calibrated_accel(*ports.calibration, accel);
        gyro = calibrated_gyro(*ports.calibration, gyro);
    }
    ports.accel.publish([&] { return SensorAccel{.timestamp_sample = time_us, .xyz = accel}; });
    ports.gyro.publish([&] { return SensorGyro{.timestamp_sample = time_us, .xyz = gyro}; });
}

}  // namespace stator::drivers::imu::mpu6000
