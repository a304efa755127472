// The registers of a USART as RM0090, chapter 30 describes them: what a driver sees of a byte in
// each direction, of errors and of its interrupt. No bits and no time; the test says when something
// happens. Offsets and bits are written out a second time, so that a wrong one in the driver shows.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <vector>

namespace stator::testing {

class UsartModel {
  public:
    static constexpr uint32_t kFramingError = 1U << 1;
    static constexpr uint32_t kNoise = 1U << 2;

    std::map<uint32_t, uint32_t> plain;  // CR1 to CR3 and BRR
    std::vector<uint8_t> wire;           // what went out
    std::function<void()> on_interrupt = [] {};

    uint32_t read(uint32_t offset) {
        if (offset == 0x00) {
            seen_ = status();
            return seen_;
        }
        if (offset != 0x04) return plain[offset];
        // 30.6.1: a read of SR and then of DR clears the flags that the first one showed.
        errors_ &= ~seen_;
        has_received_ = false;
        return data_;
    }
    void write(uint32_t offset, uint32_t value) {
        if (offset != 0x04) {
            plain[offset] = value;
            return;
        }
        if (!is_on(3)) return;
        // A byte that is written while the register is full takes its place.
        has_room_ = false;
        sending_ = static_cast<uint8_t>(value);
    }

    // --- the line ---

    // A byte comes. Without room the newest is lost (30.3.3): the register keeps its own.
    void receive(uint8_t byte, uint32_t errors = 0) {
        if (!is_on(2)) return;
        if (has_received_) {
            overrun();
            return;
        }
        data_ = byte;
        has_received_ = true;
        errors_ |= errors;
    }
    void overrun() { errors_ |= 1U << 3; }
    // The byte in the register goes out.
    void send() {
        if (has_room_) return;
        wire.push_back(sending_);
        has_room_ = true;
    }
    // While the line is raised, but not for ever: calls the handler. How often.
    unsigned interrupt() {
        constexpr unsigned kMost = 10'000;
        unsigned count = 0;
        for (; is_raised() && count < kMost; ++count) {
            on_interrupt();
            send();
        }
        return count;
    }

  private:
    bool is_on(unsigned bit) const {
        const auto found = plain.find(0x0C);
        const uint32_t control = found == plain.end() ? 0 : found->second;
        return (control & 1U << 13) != 0 && (control & 1U << bit) != 0;
    }
    uint32_t status() const {
        return errors_ | (has_received_ ? 1U << 5 : 0U) | (has_room_ ? 3U << 6 : 0U);
    }
    // RXNEIE is for overruns, too.
    bool is_raised() const {
        const bool receives = is_on(5) && (status() & (1U << 5 | 1U << 3)) != 0;
        return receives || (is_on(7) && has_room_);
    }

    uint32_t errors_ = 0;
    uint32_t seen_ = 0;
    uint8_t data_ = 0;
    uint8_t sending_ = 0;
    bool has_received_ = false;
    bool has_room_ = true;
};

// The registers of a port under test.
struct UsartWire {
    UsartModel* model = nullptr;
    uint32_t read(uint32_t offset) const { return model->read(offset); }
    void write(uint32_t offset, uint32_t value) const { model->write(offset, value); }
};

}  // namespace stator::testing
