// A serial line of the firmware, passed on to a place of the host.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "drivers/serial/socket/port.hpp"

namespace stator::plant {

// To the firmware at the rate of the line, as the emulator has none. From it as it comes: what has
// come until the line is silent is one datagram.
class Line {
  public:
    Line() = default;
    ~Line();
    Line(const Line&) = delete;
    Line& operator=(const Line&) = delete;

    // `name`: of its FIFOs, without their ends. Empty: done. Else what is wrong.
    [[nodiscard]] std::string open(const char* place, const char* name, uint32_t baud);

    // Once in each step, at the firmware's time.
    void move(uint64_t time_us);

  private:
    static constexpr std::size_t kMaxDatagram = 2048;
    static constexpr std::size_t kMostWaits = 65'536;  // what comes then is lost
    static constexpr uint64_t kBitsOfByte = 10;        // with start and stop

    void give(uint64_t time_us);
    void take();

    drivers::serial::socket::Port port_;
    int to_firmware_ = -1;
    int from_firmware_ = -1;
    uint64_t baud_ = 0;
    uint64_t last_us_ = 0;
    uint64_t bits_us_ = 0;  // bits that the line owes, times 1,000,000
    std::deque<uint8_t> waiting_;
    std::vector<uint8_t> datagram_;
};

}  // namespace stator::plant
