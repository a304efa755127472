// The monitor: what runs when no task has anything to do.
#include "stator/cortex_m.hpp"
#include "stator/events.hpp"

namespace stator {

LogEvents event_log;

void monitor() {
    // In safe mode no task runs.
    if (is_safe_mode() || all_show_life(program.watched, program.watched_count, clock_us())) {
        board::kick_watchdog();
    }
    serve_link();
}

}  // namespace stator
