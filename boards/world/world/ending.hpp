// A signal ends a simulated flight in order, with its log and its facts.
#pragma once

#include <atomic>

namespace stator::world {

// The number of the signal that asked for the end; 0: none did.
inline std::atomic<int> ending_signal = 0;

// From here on SIGINT, SIGTERM and SIGHUP are noted. They may be blocked before, so that none is
// lost.
void end_by_signals();

}  // namespace stator::world
