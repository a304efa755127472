// Threads of levels: each runs the tasks of its pending word, most urgent bit first, makes its own
// periodic releases, and sleeps on that word.
#include <linux/futex.h>
#include <sched.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <climits>
#include <cstdio>
#include <ctime>

#include "figures.hpp"
#include "internal.hpp"
#include "stator/host.hpp"
#include "stator/observe.hpp"
#include "stator/running.hpp"

namespace stator {

PendingWord pending_words[kMaxLevels];
constinit thread_local unsigned current_level = kMaxLevels;

namespace {

constexpr uint64_t kNever = UINT64_MAX;
constexpr uint64_t kSecond_ns = 1'000'000'000;

// Written before the gate opens.
uint64_t start_ns = 0;
double speed = 1.0;
std::atomic<uint32_t> gate{0};
std::atomic<uint64_t> last_release_ns{kNever};

uint64_t time_ns(clockid_t clock) {
    timespec now{};
    clock_gettime(clock, &now);
    return static_cast<uint64_t>(now.tv_sec) * kSecond_ns + static_cast<uint64_t>(now.tv_nsec);
}

// When the machine's clock is not before the graph's.
timespec machine_time(uint64_t time_us) {
    const uint64_t time_ns = start_ns + machine_ns(time_us * 1000);
    return {.tv_sec = static_cast<time_t>(time_ns / kSecond_ns),
            .tv_nsec = static_cast<long>(time_ns % kSecond_ns)};
}

// Until the word is no longer `value`, another thread wakes it, or the clock says `end_us`.
void futex_wait(std::atomic<uint32_t>& word, uint32_t value, uint64_t end_us) {
    timespec end{};
    if (end_us != kNever) end = machine_time(end_us);
    // With a bit set the time is absolute, and of CLOCK_MONOTONIC.
    syscall(SYS_futex, &word, FUTEX_WAIT_BITSET_PRIVATE, value, end_us == kNever ? nullptr : &end,
            nullptr, FUTEX_BITSET_MATCH_ANY);
}

void futex_wake(std::atomic<uint32_t>& word, int count) {
    syscall(SYS_futex, &word, FUTEX_WAKE_PRIVATE, count);
}

class LevelThread {
  public:
    bool create(unsigned level);
    bool has_ended() const { return has_ended_.load(std::memory_order_acquire); }
    void join() { pthread_join(thread_, nullptr); }
    const Task* running() const { return running_.load(std::memory_order_relaxed); }
    const LevelFacts& facts() const { return facts_; }
    uint64_t sleeps() const { return sleeps_.load(); }

  private:
    void run();
    uint64_t make_releases();
    void run_task(unsigned index);
    void sleep(uint64_t until_us);

    pthread_t thread_{};
    unsigned place_ = 0;
    const Level* level_ = nullptr;
    std::atomic<uint32_t>* word_ = nullptr;
    LevelFacts facts_;
    std::atomic<uint64_t> sleeps_{0};
    std::atomic<const Task*> running_{nullptr};
    std::atomic<bool> has_ended_{false};
};
std::array<LevelThread, kMaxLevels> threads;
std::array<Figures, std::size_t{kMaxLevels} * kMaxTasksOfLevel> figures;  // by task

bool LevelThread::create(unsigned level) {
    place_ = level;
    level_ = &program.levels[level];
    word_ = &pending_words[level].bits;
    word_->fetch_or(kAwakeBit);  // from here on, so that it is not at rest before its first round
    const ThreadAttributes attributes(level_->priority);
    const auto entry = [](void* object) -> void* {
        static_cast<LevelThread*>(object)->run();
        return nullptr;
    };
    return pthread_create(&thread_, &attributes.get(), entry, this) == 0;
}

void LevelThread::run() {
    current_level = place_;
    char name[16];
    std::snprintf(name, sizeof name, "level %u", level_->priority);
    prepare_thread(name);
    host::begin_thread();
    wait_at_gate();
    // Looked at first, as tasks may pend each other for ever.
    while ((word_->load(std::memory_order_relaxed) & kStopBit) == 0) {
        const uint64_t next_us = make_releases();
        const uint32_t tasks = word_->load(std::memory_order_relaxed) & kTaskBits;
        if (tasks != 0) {
            run_task(static_cast<unsigned>(std::countr_zero(tasks)));
        } else {
            sleep(next_us);
        }
    }
    facts_.cpu_ns = thread_cpu_ns();
    has_ended_.store(true, std::memory_order_release);
}

// Pends what is due, and returns when the next release is. A level that was late makes all releases
// that it missed; the task counts those that it served together.
uint64_t LevelThread::make_releases() {
    if (level_->timer_count == 0) return kNever;
    const uint64_t now_ns = clock_ns();
    const uint64_t last_ns = last_release_ns.load();
    uint64_t next_us = kNever;
    for (unsigned i = 0; i < level_->timer_count; ++i) {
        const Timer& timer = program.timers[level_->first_timer + i];
        uint64_t release_us = next_release_us(timer);
        while (release_us * 1000 <= std::min(now_ns, last_ns)) {
            facts_.worst_release_ns = std::max(facts_.worst_release_ns, now_ns - release_us * 1000);
            release(timer);
            release_us = next_release_us(timer);
        }
        next_us = std::min(next_us, release_us);
    }
    return next_us * 1000 <= last_ns ? next_us : kNever;
}

void LevelThread::run_task(unsigned index) {
    // Before the task runs, so that what is published from here on pends it again. Acquire: it sees
    // what was published before the bit was set. Relaxed, or cleared after the run, loses samples.
    word_->fetch_and(~(1U << index), std::memory_order_acquire);
    const unsigned place = level_->first_task + index;
    const Task& task = program.tasks[place];
    running_.store(&task, std::memory_order_relaxed);
    running_node = task.name;
    task.run();
    running_node = nullptr;
    figures[place].keep(*task.counters);
    for (unsigned i = 0; i < task.line_count; ++i) task.lines[i]->finish_activation();
    running_.store(nullptr, std::memory_order_relaxed);
}

// The word goes to 0 only if nothing but kAwakeBit is set; a thread that sets a bit from then on
// finds 0 and wakes this thread, which the kernel keeps asleep only while the word is 0.
void LevelThread::sleep(uint64_t until_us) {
    sleeps_.fetch_add(1);
    uint32_t awake = kAwakeBit;
    if (!word_->compare_exchange_strong(awake, 0)) return;
    futex_wait(*word_, 0, until_us);
    word_->fetch_or(kAwakeBit);
    ++facts_.wakes;
}

}  // namespace

void wake_level(uint32_t word) {
    futex_wake(pending_words[word].bits, 1);
}

uint64_t clock_ns() {
    const uint64_t elapsed_ns = time_ns(CLOCK_MONOTONIC) - start_ns;
    // A double has the nanoseconds of 104 days, and a product with 1 is exact.
    return static_cast<uint64_t>(static_cast<double>(elapsed_ns) * speed);
}
uint64_t clock_us() {
    return clock_ns() / 1000;
}

void sleep_until_us(uint64_t time_us) {
    const timespec end = machine_time(time_us);
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &end, nullptr) == EINTR) {
    }
}

uint64_t machine_ns(uint64_t duration_ns) {
    // One more, as the way back rounds down.
    return speed == 1.0 ? duration_ns
                        : static_cast<uint64_t>(static_cast<double>(duration_ns) / speed) + 1;
}

uint64_t graph_us(uint64_t duration_us) {
    return std::max<uint64_t>(static_cast<uint64_t>(static_cast<double>(duration_us) * speed), 1);
}

uint64_t thread_cpu_ns() {
    return time_ns(CLOCK_THREAD_CPUTIME_ID);
}

bool make_level(unsigned level) {
    return threads[level].create(level);
}

void wait_at_gate() {
    while (gate.load(std::memory_order_acquire) == 0) futex_wait(gate, 0, kNever);
}

void open_gate(double wanted_speed) {
    speed = wanted_speed;
    start_ns = time_ns(CLOCK_MONOTONIC);
    gate.store(1, std::memory_order_release);
    futex_wake(gate, INT_MAX);
}

void drop_pending() {
    for (PendingWord& word : pending_words) word.bits.store(0);
}

void stop_releases() {
    last_release_ns.store(gate.load() == 0 ? 0 : clock_ns());
    // One that should have woken, and is late: it is not at rest before it has made what was due.
    for (unsigned i = 0; i < program.level_count; ++i) {
        if (pending_words[i].bits.fetch_or(kAwakeBit) == 0) wake_level(i);
    }
}

// Sequentially consistent throughout. A level that sleeps has the word 0, and counts before each
// time that it falls asleep: where the word is 0 twice and the count is the same before the first
// and after the second look, it slept all the time between. All do so at the end of the first
// round.
bool is_any_level_busy() {
    std::array<uint64_t, kMaxLevels> sleeps{};
    for (unsigned i = 0; i < program.level_count; ++i) {
        sleeps[i] = threads[i].sleeps();
        if (pending_words[i].bits.load() != 0) return true;
    }
    for (unsigned i = 0; i < program.level_count; ++i) {
        if (pending_words[i].bits.load() != 0 || threads[i].sleeps() != sleeps[i]) return true;
    }
    return false;
}

void stop_level(unsigned level) {
    pending_words[level].bits.fetch_or(kStopBit);
    wake_level(level);
}

bool join_level(unsigned level, uint64_t end_us) {
    while (!threads[level].has_ended()) {
        if (clock_us() >= end_us) return false;
        nanosleep(&kPollPeriod, nullptr);
    }
    threads[level].join();
    return true;
}

LevelFacts facts_of_level(unsigned level) {
    return threads[level].has_ended() ? threads[level].facts() : LevelFacts{};
}

TaskCounters figures_of_task(unsigned task) {
    TaskCounters counters;
    while (!figures[task].read(counters)) sched_yield();
    return counters;
}

TaskCounters figures_of(const ObservedTask& task) {
    return figures_of_task(task.index);
}

uint32_t observed_ticks_hz() {
#ifdef STATOR_COUNTERS
    return 1'000'000'000;
#else
    return 0;
#endif
}

const Task* unended_task(unsigned level) {
    return threads[level].has_ended() ? nullptr : threads[level].running();
}

}  // namespace stator
