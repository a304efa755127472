// The same between two bare threads, of the same priorities, that hand over by a futex:
// `futex_handover SAMPLES [--plain | --one-cpu]`, as stator_handover.
#include <linux/futex.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <cstring>

#include "measured.hpp"

namespace {

using measured::Sample;

std::vector<measured::Row> rows;
Sample shared;
std::atomic<uint32_t> word{0};

void run_source() {
    prctl(PR_SET_TIMERSLACK, 1UL);
    uint64_t due_ns = measured::now_ns();
    for (std::size_t i = 0; i < rows.size(); ++i) {
        due_ns += measured::kPeriod_ns;
        measured::sleep_until(due_ns);
        const uint64_t begin_ns = measured::now_ns();
        shared = Sample{.sent_ns = begin_ns, .value = {i, 1, 2, 3, 4, 5}};
        word.store(static_cast<uint32_t>(i + 1), std::memory_order_release);
        syscall(SYS_futex, &word, FUTEX_WAKE_PRIVATE, 1);
        rows[i].call_ns = static_cast<uint32_t>(measured::now_ns() - begin_ns);
    }
}

void* run_sink(void*) {
    prctl(PR_SET_TIMERSLACK, 1UL);
    for (uint32_t seen = 0; seen < rows.size();) {
        while (word.load(std::memory_order_acquire) == seen) {
            syscall(SYS_futex, &word, FUTEX_WAIT_PRIVATE, seen, nullptr);
        }
        seen = word.load(std::memory_order_acquire);
        rows[seen - 1].latency_ns = static_cast<uint32_t>(measured::now_ns() - shared.sent_ns);
    }
    return nullptr;
}

// As the executor gives the levels 9 and 5.
void use_fifo(pthread_attr_t& attributes, int level) {
    const sched_param parameter{.sched_priority = 10 + level};
    pthread_attr_setinheritsched(&attributes, PTHREAD_EXPLICIT_SCHED);
    pthread_attr_setschedpolicy(&attributes, SCHED_FIFO);
    pthread_attr_setschedparam(&attributes, &parameter);
}

// As `Settings::cpus` = 1. The threads that are made from here on inherit it.
void stay_on_one_cpu() {
    cpu_set_t cpus;
    CPU_ZERO(&cpus);
    CPU_SET(0, &cpus);
    sched_setaffinity(0, sizeof cpus, &cpus);
}

}  // namespace

int main(int count, char** arguments) {
    if (count < 2) return 2;
    rows.resize(std::strtoul(arguments[1], nullptr, 10));
    const char* const option = count > 2 ? arguments[2] : "";
    const bool plain = std::strcmp(option, "--plain") == 0;
    pthread_attr_t of_source;
    pthread_attr_t of_sink;
    pthread_attr_init(&of_source);
    pthread_attr_init(&of_sink);
    if (!plain) use_fifo(of_source, 9);
    if (!plain) use_fifo(of_sink, 5);
    if (!plain) mlockall(MCL_CURRENT);
    if (std::strcmp(option, "--one-cpu") == 0) stay_on_one_cpu();
    pthread_t source;
    pthread_t sink;
    const auto run = [](void*) -> void* {
        run_source();
        return nullptr;
    };
    if (pthread_create(&sink, &of_sink, run_sink, nullptr) != 0 ||
        pthread_create(&source, &of_source, run, nullptr) != 0) {
        std::fputs("not allowed: SCHED_FIFO\n", stderr);
        return 2;
    }
    pthread_join(source, nullptr);
    pthread_join(sink, nullptr);
    measured::print(rows);
    return 0;
}
