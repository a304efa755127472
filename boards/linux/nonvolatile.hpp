// The file of a run in which records outlive it.
#pragma once

namespace stator::board {

// Gives the file to the device `nonvolatile0`; makes one that is not there. False, after lines that
// say what is wrong and what to do, if it cannot be opened, holds something else, or another run
// has it.
[[nodiscard]] bool open_nonvolatile(const char* path);
// What the device reports, as a member of a JSON object, with a comma behind it.
void print_nonvolatile();

}  // namespace stator::board
