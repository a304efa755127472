// What the files of this executor know of each other.
#pragma once

#include <pthread.h>

#include <ctime>

#include "stator/pthread.hpp"

namespace stator {

inline constexpr timespec kPollPeriod{.tv_sec = 0, .tv_nsec = 200'000};

// --- permission.cpp ---

// How a thread is to be made: its priority and processors as far as they are granted.
class ThreadAttributes {
  public:
    explicit ThreadAttributes(unsigned priority);
    ~ThreadAttributes() { pthread_attr_destroy(&attributes_); }
    ThreadAttributes(const ThreadAttributes&) = delete;
    ThreadAttributes& operator=(const ThreadAttributes&) = delete;
    const pthread_attr_t& get() const { return attributes_; }

  private:
    pthread_attr_t attributes_;
};

// Asks the machine for what the settings want, once, before any thread is made.
void ask_permission(const Settings& settings);
// Once all are made.
void ask_for_memory(const Settings& settings);
// At the begin of a thread: names it and touches its stack, so that no activation is the first to.
void prepare_thread(const char* name);
// How long the machine takes for what is so long by the graph's clock.
uint64_t machine_ns(uint64_t duration_ns);
// How much the graph's clock makes of so long a time of the machine; at least 1.
uint64_t graph_us(uint64_t duration_us);

// Above those of all levels, as interrupts are.
inline constexpr unsigned kDevicePriority = 16;

// --- level.cpp ---

// Threads are made first, and wait at the gate.
bool make_level(unsigned level);
void wait_at_gate();
void open_gate(double speed);  // time begins
void drop_pending();
void stop_releases();             // what is due by now is still released, late as it may be
bool is_any_level_busy();         // two looks: true unless all slept in between
void stop_level(unsigned level);  // once its task has ended
// False if it has not ended at time `end_us`: then its thread stays.
[[nodiscard]] bool join_level(unsigned level, uint64_t end_us);
// What the task had counted at the end of its newest activation. A level needs some nanoseconds to
// write that; meanwhile, this waits. Context: a thread less urgent than all levels.
TaskCounters figures_of_task(unsigned task);

// --- link.cpp: of the thread that waits for the end ---

// What to wait for until a request comes on the link; -1: nothing, or not yet.
int link_events(uint64_t now_us);
// When the link may be looked at again, if that is not now.
uint64_t next_link_turn_us(uint64_t now_us);
void serve_link(uint64_t now_us);
void close_link();

// --- line.cpp ---

bool start_lines();
void stop_lines();

}  // namespace stator
