// The levels of the chip's pins: what the chip and what the board drive.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace stator::chip {

// "PD15" as a number: 16 for each port.
constexpr unsigned pin(char port, unsigned number) {
    return static_cast<unsigned>(port - 'A') * 16 + number;
}
std::string name_of_pin(unsigned pin);

enum class Drive : uint8_t { kNone, kPullDown, kPullUp, kLow, kHigh };

class Pins {
  public:
    static constexpr unsigned kPins = 9 * 16;

    // What drives a pin from inside and from outside; throws `Violation` if both do, and differ.
    void set_inside(unsigned pin, Drive drive) { set(pin, pins_[pin].inside, drive); }
    void set_outside(unsigned pin, Drive drive) { set(pin, pins_[pin].outside, drive); }
    // A pin that nothing drives reads low.
    bool is_high(unsigned pin) const { return pins_[pin].is_high; }
    // Called at each change, in the order in which they asked.
    void watch(unsigned pin, std::function<void(bool is_high)> watcher) {
        pins_[pin].watchers.push_back(std::move(watcher));
    }

  private:
    struct Pin {
        Drive inside = Drive::kNone;
        Drive outside = Drive::kNone;
        bool is_high = false;
        std::vector<std::function<void(bool)>> watchers;
    };
    void set(unsigned pin, Drive& end, Drive drive);

    std::vector<Pin> pins_ = std::vector<Pin>(kPins);
};

}  // namespace stator::chip
