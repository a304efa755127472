// The file with the key of MAVLink's signatures.
#pragma once

#include "stator/mavlink/shared_key.hpp"

namespace stator::world {

// Its first line: 64 hexadecimal digits, or a phrase, whose SHA-256 is the key, as ground stations
// make it. False after one line that says what is wrong.
[[nodiscard]] bool read_key(const char* path, mav::SharedKey& key);

}  // namespace stator::world
