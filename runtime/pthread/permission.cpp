// Threads, and what they need from the machine for real time: a real-time priority, locked memory,
// chosen processors. A refused permission is noted with its cost; the graph runs without it.
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>

#include <cerrno>
#include <climits>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <memory>

#include "internal.hpp"

namespace stator {

namespace {

// Of the kernel's 1 to 99: under the threads of interrupts, which are at 50 on a PREEMPT_RT kernel.
constexpr int kPriorityOfLevel1 = 11;
constexpr std::size_t kStackBytes = std::size_t{512} * 1024;
constexpr std::size_t kTouchedBytes = std::size_t{64} * 1024;  // of each stack
constexpr std::size_t kPageBytes = 4096;

std::vector<Refusal> refused;
bool has_fifo = false;
bool has_cpus = false;
cpu_set_t cpus;

sched_param parameter_of(unsigned priority) {
    return {.sched_priority = kPriorityOfLevel1 - 1 + static_cast<int>(priority)};
}

// Tries the priority on this thread, and restores the old one.
void ask_for_fifo() {
    sched_param before{};
    const int policy = sched_getscheduler(0);
    sched_getparam(0, &before);
    const sched_param wanted = parameter_of(kDevicePriority);
    has_fifo = sched_setscheduler(0, SCHED_FIFO, &wanted) == 0;
    if (has_fifo) {
        sched_setscheduler(0, policy, &before);
        return;
    }
    refused.push_back({"SCHED_FIFO", std::strerror(errno),
                       "other programs and less urgent levels can delay an urgent one by "
                       "milliseconds under load",
                       "set ulimit -r 40, or run with CAP_SYS_NICE"});
}

// Locks the existing memory only. A running graph allocates no new memory; and if only little may
// be locked, a lock of future memory would prevent new threads.
void lock_memory() {
    if (mlockall(MCL_CURRENT) == 0) return;
    refused.push_back({"locked memory", std::strerror(errno),
                       "the first access to a page, or to one that was swapped out, delays an "
                       "activation",
                       "set ulimit -l unlimited, or run with CAP_IPC_LOCK"});
}

void ask_for_cpus(uint64_t wanted) {
    CPU_ZERO(&cpus);
    for (unsigned cpu = 0; cpu < 64; ++cpu) {
        if ((wanted >> cpu & 1U) != 0) CPU_SET(cpu, &cpus);
    }
    cpu_set_t before;
    sched_getaffinity(0, sizeof before, &before);
    has_cpus = sched_setaffinity(0, sizeof cpus, &cpus) == 0;
    if (has_cpus) {
        sched_setaffinity(0, sizeof before, &before);
        return;
    }
    refused.push_back({"the chosen processors", std::strerror(errno),
                       "levels run on any processor, and move between them",
                       "choose processors that this machine has and that you may use"});
}

// Touches the stack below this frame, page by page.
[[gnu::noinline]] void touch_stack() {
    [[maybe_unused]] volatile std::byte pages[kTouchedBytes];
    for (std::size_t at = 0; at < kTouchedBytes; at += kPageBytes) pages[at] = std::byte{};
}

}  // namespace

void ask_permission(const Settings& settings) {
    if (settings.real_time) ask_for_fifo();
    if (settings.cpus != 0) ask_for_cpus(settings.cpus);
}

void ask_for_memory(const Settings& settings) {
    if (settings.real_time) lock_memory();
}

const std::vector<Refusal>& refusals() {
    return refused;
}
bool is_real_time() {
    return has_fifo;
}

ThreadAttributes::ThreadAttributes(unsigned priority) {
    pthread_attr_init(&attributes_);
    pthread_attr_setstacksize(&attributes_, kStackBytes);
    if (has_cpus) pthread_attr_setaffinity_np(&attributes_, sizeof cpus, &cpus);
    if (!has_fifo) return;
    const sched_param parameter = parameter_of(priority);
    pthread_attr_setinheritsched(&attributes_, PTHREAD_EXPLICIT_SCHED);
    pthread_attr_setschedpolicy(&attributes_, SCHED_FIFO);
    pthread_attr_setschedparam(&attributes_, &parameter);
}

void prepare_thread(const char* name) {
    prctl(PR_SET_NAME, name);
    // Without a real-time priority the kernel may add 50 us to each timed sleep.
    prctl(PR_SET_TIMERSLACK, 1UL);
    touch_stack();
}

namespace {

struct DeviceThread {
    char name[16];
    void (*run)(void*);
    void* object;
};

void* run_device_thread(void* argument) {
    const std::unique_ptr<DeviceThread> thread(static_cast<DeviceThread*>(argument));
    prepare_thread(thread->name);
    thread->run(thread->object);
    return nullptr;
}

}  // namespace

bool make_device_thread(pthread_t& thread, const char* name, void (*run)(void*), void* object) {
    auto start = std::make_unique<DeviceThread>(DeviceThread{{}, run, object});
    std::snprintf(start->name, sizeof start->name, "%s", name);
    const ThreadAttributes attributes(kDevicePriority);
    if (pthread_create(&thread, &attributes.get(), run_device_thread, start.get()) != 0) {
        return false;
    }
    static_cast<void>(start.release());  // the thread has it now
    return true;
}

}  // namespace stator
