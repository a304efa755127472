#include "chip/pins.hpp"

#include <algorithm>

#include "chip/violation.hpp"

namespace stator::chip {

std::string name_of_pin(unsigned pin) {
    return std::string("P") + static_cast<char>('A' + pin / 16) + std::to_string(pin % 16);
}

void Pins::set(unsigned pin, Drive& end, Drive drive) {
    end = drive;
    Pin& changed = pins_[pin];
    const Drive stronger = std::max(changed.inside, changed.outside);
    const Drive weaker = std::min(changed.inside, changed.outside);
    if (stronger == Drive::kHigh && weaker == Drive::kLow) {
        throw Violation(name_of_pin(pin) + ": driven low by one end and high by the other");
    }
    const bool is_high = stronger == Drive::kHigh || stronger == Drive::kPullUp;
    if (is_high == changed.is_high) return;
    changed.is_high = is_high;
    for (const auto& watcher : changed.watchers) watcher(is_high);
}

}  // namespace stator::chip
