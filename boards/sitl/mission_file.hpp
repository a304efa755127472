// A mission that the command line gives, as the bytes of its message.
#pragma once

#include "messages/mission.hpp"

namespace stator::board {

// False after one line on the standard error output that says what is wrong.
[[nodiscard]] bool read_mission(const char* path, Mission& mission);

}  // namespace stator::board
