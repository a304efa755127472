#include "world/ending.hpp"

#include <csignal>

namespace stator::world {

void end_by_signals() {
    const auto note = [](int number) { ending_signal.store(number); };
    std::signal(SIGINT, note);
    std::signal(SIGTERM, note);
    if (std::signal(SIGHUP, note) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);  // nohup
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_UNBLOCK, &all, nullptr);
}

}  // namespace stator::world
