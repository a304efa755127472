// The file of a run that is the memory of its mission device.
#pragma once

namespace stator::board {

// Gives the file to the device `mission0`. False after a line that says what is wrong.
[[nodiscard]] bool open_mission(const char* path);

}  // namespace stator::board
