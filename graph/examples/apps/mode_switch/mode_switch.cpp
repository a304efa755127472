#include "mode_switch.hpp"

namespace stator::apps::mode_switch {

void ModeSwitch::step(ModeSwitchPorts& ports) {
    mode_ = mode_ == 0 ? 1 : 0;
    ports.mode.publish([&] { return Mode{.mode = mode_}; });
}

}  // namespace stator::apps::mode_switch
