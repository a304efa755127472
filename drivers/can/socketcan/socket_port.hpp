// A CAN interface of Linux (SocketCAN), through a raw socket.
#pragma once

#include <array>
#include <cstdint>

#include "../can_driver.hpp"

struct can_frame;  // of <linux/can.h>

namespace stator::drivers::can::socketcan {

// Opens the interface as soon as it is there and up, and again when it went away and came back.
class SocketPort {
  public:
    struct Filter {
        uint32_t id;    // with the flags of <linux/can.h>
        uint32_t mask;  // bits that count
    };
    struct Device {
        static constexpr unsigned kMaxFilters = 8;
        const char* interface = nullptr;  // such as can0; none: the bus is down
        // Which frames the kernel hands over; none: all data frames.
        std::array<Filter, kMaxFilters> filters{};
        unsigned filter_count = 0;
        double clock_speed = 1.0;  // of the program's clock against the machine's
        // The board waits for the descriptor, and stops that before it is closed. May be null.
        void (*watch)(int descriptor) = nullptr;
        void (*unwatch)() = nullptr;
    };

    explicit SocketPort(Device& device) : device_(device) {}

    void begin(uint64_t now_us);
    CanSend send(const CanFrame& frame);
    bool take_back(CanFrame&) { return false; }  // what the kernel has, it keeps
    bool receive(CanFrame& frame, uint64_t now_us);
    void end() {}
    CanInterfaceStatus::State state() const { return state_; }
    void count(CanInterfaceStatus& status) const;

  private:
    using State = CanInterfaceStatus::State;

    static constexpr unsigned kMaxFetched = 8;

    bool open();
    void close();
    bool fetch(uint64_t now_us);
    void sort(const can_frame& raw, bool is_whole, uint64_t seen_us);
    void take_error_frame(uint32_t kind, const uint8_t* data);
    void fail(int error);

    Device& device_;
    std::array<CanFrame, kMaxFetched> fetched_{};
    unsigned fetched_count_ = 0;
    unsigned taken_ = 0;
    uint64_t fetched_us_ = 0;
    uint64_t next_open_us_ = 0;
    uint64_t io_errors_ = 0;
    uint32_t rx_lost_before_ = 0;  // by sockets that are closed
    uint32_t rx_lost_ = 0;
    uint32_t rx_overflows_ = 0;
    uint32_t rx_ignored_ = 0;
    uint32_t bus_off_count_ = 0;
    int socket_ = -1;
    State state_ = State::kDown;
};

}  // namespace stator::drivers::can::socketcan
