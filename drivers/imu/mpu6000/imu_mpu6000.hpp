// The MPU6000 on a serial bus (InvenSense, register map RM-MPU-6000A, product specification
// PS-MPU-6000A): starts the part, publishes its samples, and looks whether its registers still have
// what was written.
#pragma once

#include <array>
#include <cstdint>

#include "imu_ports.hpp"
#include "stator/one_core_topic.hpp"

namespace stator::drivers::imu::mpu6000 {

// Bytes out, and as many in at the same time. The first one is the register; bit 7: read.
struct Transfer {
    static constexpr uint8_t kMaxBytes = 15;
    std::array<uint8_t, kMaxBytes> bytes{};
    uint8_t count = 0;     // 0: none
    bool is_fast = false;  // of sensor registers: up to 20 MHz; of all others up to 1 MHz
};

class ImuMpu6000 {
  public:
    // What the driver and its bus hand to each other. `state` says whose the rest is: the bus's
    // while armed, and the driver's while idle.
    struct Device {
        enum State : uint32_t { kIdle, kArmed };
        Shared<uint32_t> state;
        // The bus starts the first one at the next ready line, or after 2 ms without one; the
        // second one follows. What came in replaces the bytes.
        Transfer first;
        Transfer second;
        uint64_t time_us = 0;   // of the line, or of the start
        bool is_ready = false;  // the line started it
        // The body's axes as the part's: 1 to 3, negative if they are opposite.
        std::array<int8_t, 3> axes{1, 2, 3};
        // For people.
        uint32_t resets = 0;
        uint32_t bad = 0;           // samples that were not published
        uint32_t missed_lines = 0;  // samples that no line announced
    };

    explicit ImuMpu6000(Device& device) : device_(device) {}
    void step(ImuPorts& ports);

  private:
    enum class Phase : uint8_t { kReset, kStart, kIdentify, kWake, kSettle, kConfigure, kRun };

    // Off the path of a sample, where size counts.
    [[gnu::cold, gnu::noinline]] void start(uint64_t now_us);
    [[gnu::cold, gnu::noinline]] void reset();
    void identify(uint64_t now_us);
    void write_next();
    void measure(ImuPorts& ports);
    bool is_good();
    void compare();
    void publish(ImuPorts& ports);
    void read(Transfer& transfer, uint8_t reg, uint8_t count, bool is_fast);
    void write(uint8_t reg, uint8_t value);

    Device& device_;
    Phase phase_ = Phase::kReset;
    uint64_t wait_us_ = 0;   // nothing before
    uint64_t retry_us_ = 0;  // when the part is reset again, if it does not answer
    bool has_asked_ = false;
    uint8_t next_write_ = 0;
    uint8_t checked_ = 0;  // index of the register that is compared next
    bool checks_ = false;  // whether the second transfer is a comparison
    unsigned samples_ = 0;
    unsigned equal_ = 0;  // samples in a row that are the same
    unsigned failures_ = 0;
    unsigned silent_ = 0;  // samples in a row without a line
    std::array<uint8_t, Transfer::kMaxBytes> last_{};
};

}  // namespace stator::drivers::imu::mpu6000
