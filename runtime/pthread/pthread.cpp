// Starts a graph, waits for its end, ends it in order.
#include "stator/pthread.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <iterator>

#include "internal.hpp"
#include "stator/mutex.hpp"

namespace stator {

LogEvents event_log;

namespace {

constexpr uint64_t kLongestEnd_us = 1'000'000;
constexpr uint64_t kWatchPeriod_us = 5'000;

int signals = -1;
int stops = -1;  // an event
int heard = 0;

bool refuse(const char* what) {
    std::fprintf(stderr, "error: cannot start: %s: %s\n", what, std::strerror(errno));
    return false;
}

// SIGHUP is among them where it would end the process: nohup ignores it.
sigset_t ending_signals() {
    sigset_t ending;
    sigemptyset(&ending);
    sigaddset(&ending, SIGINT);
    sigaddset(&ending, SIGTERM);
    struct sigaction hang_up {};
    if (sigaction(SIGHUP, nullptr, &hang_up) == 0 && hang_up.sa_handler == SIG_DFL) {
        sigaddset(&ending, SIGHUP);
    }
    return ending;
}

// Blocked in all threads that are made from here on; `wait_until` hears them.
bool take_signals() {
    const sigset_t ending = ending_signals();
    pthread_sigmask(SIG_BLOCK, &ending, nullptr);
    signals = signalfd(-1, &ending, SFD_CLOEXEC | SFD_NONBLOCK);
    stops = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    return signals >= 0 && stops >= 0;
}

}  // namespace

void fail(const char* what) {
    std::fprintf(stderr, "stator: %s at %llu us\n", what,
                 static_cast<unsigned long long>(clock_us()));
    std::abort();
}

Mutex::Mutex() {
    pthread_mutexattr_t attributes;
    pthread_mutexattr_init(&attributes);
    pthread_mutexattr_setprotocol(&attributes, PTHREAD_PRIO_INHERIT);
    pthread_mutex_init(&mutex_, &attributes);
    pthread_mutexattr_destroy(&attributes);
}

namespace {

// False if a task has not ended at time `end_us`.
bool end_levels(unsigned count, uint64_t end_us) {
    for (unsigned level = 0; level < count; ++level) stop_level(level);
    bool all_ended = true;
    for (unsigned level = 0; level < count; ++level) {
        all_ended = join_level(level, end_us) && all_ended;
    }
    return all_ended;
}

// What there is of threads ends without having run a task.
bool cancel(unsigned levels, const char* what) {
    refuse(what);
    close_link();
    stop_releases();
    drop_pending();
    for (unsigned level = 0; level < levels; ++level) stop_level(level);
    open_gate(1.0);
    static_cast<void>(end_levels(levels, UINT64_MAX));
    return false;
}

}  // namespace

bool start(const Settings& settings) {
    if (!take_signals()) return refuse("signals");
    ask_permission(settings);
    program.start();
    for (unsigned level = 0; level < program.level_count; ++level) {
        if (!make_level(level)) return cancel(level, "the thread of a level");
    }
    if (!start_lines()) {
        return cancel(program.level_count, "the thread of lines");
    }
    ask_for_memory(settings);
    open_gate(settings.speed);
    return true;
}

Ending wait_until(uint64_t end_us) {
    for (;;) {
        const uint64_t now_us = clock_us();
        if (now_us >= end_us) return Ending::kTime;
        all_show_life(program.watched, program.watched_count, now_us);
        const uint64_t next_us = std::min(end_us, next_link_turn_us(now_us));
        const uint64_t left_ns = machine_ns(1000 * std::min(next_us - now_us, kWatchPeriod_us));
        const timespec left{.tv_sec = static_cast<time_t>(left_ns / 1'000'000'000),
                            .tv_nsec = static_cast<long>(left_ns % 1'000'000'000)};
        pollfd waits[] = {
            {stops, POLLIN, 0}, {signals, POLLIN, 0}, {link_events(now_us), POLLIN, 0}};
        if (ppoll(waits, std::size(waits), &left, nullptr) <= 0) continue;
        if (waits[0].revents != 0) return Ending::kStopped;
        if (waits[2].revents != 0) serve_link(clock_us());
        if (waits[1].revents == 0) continue;
        signalfd_siginfo info{};
        if (read(signals, &info, sizeof info) != sizeof info) continue;
        heard = static_cast<int>(info.ssi_signo);
        return Ending::kSignal;
    }
}

int ending_signal() {
    return heard;
}

void stop() {
    eventfd_write(stops, 1);
}

bool wait_until_idle(uint64_t longest_us) {
    const uint64_t end_us = clock_us() + longest_us;
    while (is_any_level_busy()) {
        if (clock_us() >= end_us) return false;
        nanosleep(&kPollPeriod, nullptr);
    }
    return true;
}

namespace {

// Those that came since the first one are forgotten; the next does what it does to any program.
void give_signals_back() {
    signalfd_siginfo info{};
    while (read(signals, &info, sizeof info) == sizeof info) {
    }
    const sigset_t ending = ending_signals();
    pthread_sigmask(SIG_UNBLOCK, &ending, nullptr);
}

}  // namespace

bool finish() {
    close_link();
    stop_lines();
    stop_releases();
    const bool came_to_rest = wait_until_idle(kLongestEnd_us);
    const bool all_ended = end_levels(program.level_count, clock_us() + kLongestEnd_us);
    if (!all_ended) {
        give_signals_back();
        return false;  // a task that is left may still call `stop`
    }
    close(signals);
    close(stops);
    return came_to_rest;
}

}  // namespace stator
