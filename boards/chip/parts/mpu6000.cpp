#include "parts/mpu6000.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace stator::chip {

namespace {

constexpr uint8_t kDivider = 0x19, kFilter = 0x1A, kGyro = 0x1B, kAccel = 0x1C, kPin = 0x37,
                  kEnable = 0x38, kStatus = 0x3A, kSamples = 0x3B, kPaths = 0x68, kUser = 0x6A,
                  kPower = 0x6B, kWhoAmI = 0x75;
constexpr uint8_t kReset = 0x80, kSleep = 0x40;
constexpr uint64_t kMillisecond_ns = 1'000'000;
constexpr uint64_t kRegistersStart_ns =
    11 * kMillisecond_ns;                                 // PS, 6.3; the driver must wait longer
constexpr uint64_t kGyroStart_ns = 30 * kMillisecond_ns;  // PS, 6.1
constexpr uint64_t kPulse_ns = 50'000;                    // RM, 4.21
constexpr uint32_t kMaxClock_hz = 1'000'000, kMaxSampleClock_hz = 20'000'000;  // PS, 6.5
constexpr double kGravity = 9.80665, kDegree = 3.14159265358979323846 / 180;

void put(uint8_t* at, double value) {
    const auto raw = static_cast<int16_t>(std::clamp(std::round(value), -32768.0, 32767.0));
    at[0] = static_cast<uint8_t>(static_cast<uint16_t>(raw) >> 8);
    at[1] = static_cast<uint8_t>(raw);
}

}  // namespace

Mpu6000::Mpu6000(Chip& chip, unsigned line, Source source)
    : chip_(chip), line_(line), source_(std::move(source)) {
    reset();
}

void Mpu6000::reset() {
    registers_.fill(0);
    registers_[kPower] = kSleep;
    registers_[kWhoAmI] = 0x68;
    shown_.fill(0);
    ready_ns_ = chip_.now_ns() + kRegistersStart_ns;
    ++generation_;
    set_line(false);
}

void Mpu6000::brown_out() {
    reset();
}

void Mpu6000::set_line(bool is_active) {
    const bool is_low_active = (registers_[kPin] & 0x80) != 0;
    chip_.pins().set_outside(line_, is_active != is_low_active ? Drive::kHigh : Drive::kLow);
}

uint64_t Mpu6000::period_ns() const {
    const uint8_t filter = registers_[kFilter] & 7;
    const uint64_t rate_hz = filter == 0 || filter == 7 ? 8'000 : 1'000;
    return (registers_[kDivider] + 1ULL) * 1'000'000'000 / rate_hz;
}

void Mpu6000::start() {
    const unsigned generation = ++generation_;
    chip_.at(chip_.now_ns() + kGyroStart_ns, [this, generation] { sample(generation); });
}

void Mpu6000::sample(unsigned generation) {
    if (generation != generation_) return;  // asleep or reset since
    chip_.at(chip_.now_ns() + period_ns(), [this, generation] { sample(generation); });
    ++samples_;
    if (!faults.is_stuck) {
        const Motion motion = source_(chip_.now_ns());
        const double gyro_lsb = 131.072 / (1 << (registers_[kGyro] >> 3 & 3));
        const double accel_lsb = 16384.0 / (1 << (registers_[kAccel] >> 3 & 3));
        for (unsigned i = 0; i < 3; ++i) {
            put(&shown_[2 * i], motion.force[i] / kGravity * accel_lsb);
            put(&shown_[8 + 2 * i], motion.rate[i] / kDegree * gyro_lsb);
        }
        put(&shown_[6], (motion.temperature_c - 36.53) * 340);
    }
    registers_[kStatus] |= 1;
    if ((registers_[kEnable] & 1) == 0 || faults.is_silent || faults.has_no_line) return;
    set_line(true);
    chip_.at(chip_.now_ns() + kPulse_ns, [this] { set_line(false); });
}

void Mpu6000::select(bool is_selected) {
    if (is_selected) has_address_ = false;
}

uint8_t Mpu6000::exchange(uint8_t sent, uint32_t clock_hz, unsigned mode) {
    if (mode != 0 && mode != 3) throw Violation("MPU6000: expected SPI mode 0 or 3");
    if (clock_hz > kMaxSampleClock_hz) throw Violation("MPU6000: clock above 20 MHz");
    if (!has_address_) {
        has_address_ = true;
        is_read_ = (sent & 0x80) != 0;
        address_ = sent & 0x7F;
        return 0xFF;
    }
    const uint8_t reg = address_;
    address_ = static_cast<uint8_t>((address_ + 1) % kRegisters);
    const bool is_sample = is_read_ && reg >= kStatus && reg <= 0x48;
    if (!is_sample && clock_hz > kMaxClock_hz) {
        throw Violation("MPU6000: register " + hex(reg) + " with a clock above 1 MHz");
    }
    if (faults.is_silent) return 0xFF;
    if (chip_.now_ns() < ready_ns_) return 0x00;
    if (is_read_ && reg == kSamples + shown_.size() - 1 && read_sample_ != samples_) {
        read_sample_ = samples_;
        if (bursts_++ == 0) first_sample_ = samples_;
    }
    if (is_read_) return read(reg);
    write(reg, sent);
    return 0xFF;
}

uint8_t Mpu6000::read(uint8_t reg) const {
    if (reg >= kSamples && reg < kSamples + shown_.size()) return shown_[reg - kSamples];
    return reg == kWhoAmI ? faults.identity : registers_[reg];
}

void Mpu6000::write(uint8_t reg, uint8_t value) {
    if (reg == kPower && (value & kReset) != 0) {
        reset();
        return;
    }
    const bool was_asleep = (registers_[kPower] & kSleep) != 0;
    if (reg == kPaths) value = 0;                                   // clear themselves
    if (reg == kUser) value = static_cast<uint8_t>(value & ~0x07);  // as these
    registers_[reg] = value;
    if (reg == kPin) set_line(false);
    if (reg == kPower && (value & kSleep) == 0 && was_asleep) start();
    if (reg == kPower && (value & kSleep) != 0) ++generation_;
}

}  // namespace stator::chip
