// A recording of sensors in memory.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace stator::board {

// One sample of one device: a row of float64, little-endian, in the file.
struct Row {
    double arrival_us;             // when the device shows it; grows from row to row
    double device;                 // a Row::Device
    double timestamp_sample;       // us
    std::array<double, 9> values;  // unused ones are 0

    enum Device : int {
        kImu = 0,   // gyro xyz [rad/s], accelerometer xyz [m/s^2], body frame
        kMag = 1,   // xyz [gauss], body frame
        kGnss = 2,  // latitude, longitude [deg], height above sea [m], velocity N, E, D [m/s],
                    // horizontal error [m], vertical error [m], error of speed [m/s]
        kBaro = 3,  // pressure [Pa]
    };
};
static_assert(sizeof(Row) == 12 * sizeof(double));

class Recording {
  public:
    // False after one line on the standard error output that says what is wrong.
    [[nodiscard]] bool load(const char* path);

    std::size_t size() const { return rows_.size(); }
    const Row& operator[](std::size_t row) const { return rows_[row]; }
    static std::uint64_t time_us(const Row& row) {
        return static_cast<std::uint64_t>(row.arrival_us);
    }
    std::uint64_t end_us() const { return time_us(rows_.back()); }

  private:
    std::vector<Row> rows_;
};

}  // namespace stator::board
