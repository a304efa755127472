// A recording of sensors in memory.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace stator::board {

// Planes of float32, little-endian, one after another, each with one value per sample: gyro xyz
// [rad/s], accelerometer xyz [m/s^2], magnetometer xyz [uT], then five that hold the truth, which
// no device shows. Body frame is the sensor's.
class Recording {
  public:
    enum class Plane : std::size_t { kGyro = 0, kAccel = 3, kMag = 6 };
    static constexpr std::size_t kPlanes = 14;
    static constexpr std::uint64_t kPeriod_us = 3500;  // 285.714 Hz

    // False after one line on the standard error output that says what is wrong.
    [[nodiscard]] bool load(const char* path);

    std::size_t samples() const { return values_.size() / kPlanes; }
    // The first sample ends the first period.
    static std::uint64_t time_us(std::size_t sample) { return (sample + 1) * kPeriod_us; }
    std::array<float, 3> xyz(Plane first, std::size_t sample) const;

  private:
    std::vector<float> values_;
};

}  // namespace stator::board
