// Lines, and the one thread that waits for all their descriptors.
#include "stator/line.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>

#include "internal.hpp"

namespace stator {

namespace {

constexpr uint64_t kBrokenPause_us = 10'000;
constexpr unsigned kMaxEvents = 16;  // of one look
const int kEpoll = epoll_create1(EPOLL_CLOEXEC);

}  // namespace

bool Line::raise() {
    if (state_ == nullptr) return true;  // the graph does not use it
    if (!accept_line(*state_, clock_us(), min_interarrival_us_)) return false;
    state_->fires.store(state_->fires.load() + 1);
    set_pending(pend_);
    return true;
}

bool Line::is_served() const {
    // Acquire: the task has read its device.
    return state_ == nullptr || served_.load(std::memory_order_acquire) == state_->fires.load();
}

void Line::finish_activation() {
    if (served_.load(std::memory_order_relaxed) == state_->served) return;  // another trigger
    served_.store(state_->served, std::memory_order_release);
    if (!is_held_.load(std::memory_order_acquire)) arm(EPOLL_CTL_MOD);
}

bool Line::watch(int fd, uint32_t events) {
    unwatch();
    events_.store(events, std::memory_order_relaxed);
    is_held_.store(false, std::memory_order_relaxed);
    fd_.store(fd, std::memory_order_release);
    return arm(EPOLL_CTL_ADD);
}

void Line::unwatch() {
    const int fd = fd_.exchange(-1, std::memory_order_acq_rel);
    if (fd >= 0) epoll_ctl(kEpoll, EPOLL_CTL_DEL, fd, nullptr);
}

// For one event: what comes in before the task has run again raises nothing. A descriptor that went
// away meanwhile is no error.
bool Line::arm(int operation) {
    const int fd = fd_.load(std::memory_order_acquire);
    if (fd < 0) return false;
    epoll_event event{};
    event.events = events_.load(std::memory_order_relaxed) | EPOLLONESHOT;
    event.data.ptr = this;
    return epoll_ctl(kEpoll, operation, fd, &event) == 0;
}

// Waits for descriptors, raises their lines, and keeps those that have to wait.
class LineThread {
  public:
    void run() {
        wait_at_gate();
        epoll_event events[kMaxEvents];
        for (;;) {
            const int count = epoll_wait(kEpoll, events, kMaxEvents, timeout_ms());
            for (int i = 0; i < count; ++i) {
                if (events[i].data.ptr == nullptr) return;  // the event that stops it
                take(*static_cast<Line*>(events[i].data.ptr), events[i].events);
            }
            arm_held();
        }
    }

  private:
    static void take(Line& line, uint32_t events);
    static void hold(Line& line, uint64_t pause_us);
    static int timeout_ms();
    static void arm_held();

    static std::vector<Line*> held_;
};
std::vector<Line*> LineThread::held_;

void LineThread::take(Line& line, uint32_t events) {
    // Held before it is raised: else the end of the activation would arm it.
    const bool is_broken = (events & (EPOLLERR | EPOLLHUP)) != 0;
    if (is_broken) hold(line, kBrokenPause_us);
    const bool is_accepted = line.raise();
    if (!is_accepted && !is_broken) hold(line, line.min_interarrival_us_);
}

void LineThread::hold(Line& line, uint64_t pause_us) {
    line.held_until_us_ = clock_us() + pause_us;
    line.is_held_.store(true, std::memory_order_release);
    held_.push_back(&line);
}

int LineThread::timeout_ms() {
    if (held_.empty()) return -1;
    uint64_t first_us = UINT64_MAX;
    for (const Line* line : held_) first_us = std::min(first_us, line->held_until_us_);
    const uint64_t now_us = clock_us();
    if (first_us <= now_us) return 0;
    return static_cast<int>(machine_ns(1000 * (first_us - now_us)) / 1'000'000 + 1);
}

void LineThread::arm_held() {
    const uint64_t now_us = clock_us();
    std::erase_if(held_, [now_us](Line* line) {
        if (now_us < line->held_until_us_) return false;
        line->is_held_.store(false, std::memory_order_release);
        line->arm(EPOLL_CTL_MOD);
        return true;
    });
}

namespace {

LineThread line_thread;
pthread_t thread;
int stop_event = -1;

}  // namespace

bool start_lines() {
    stop_event = eventfd(0, EFD_CLOEXEC);
    epoll_event event{};
    event.events = EPOLLIN;
    event.data.ptr = nullptr;
    if (stop_event < 0 || epoll_ctl(kEpoll, EPOLL_CTL_ADD, stop_event, &event) != 0) return false;
    const auto run = [](void* object) { static_cast<LineThread*>(object)->run(); };
    return make_device_thread(thread, "lines", run, &line_thread);
}

void stop_lines() {
    eventfd_write(stop_event, 1);
    pthread_join(thread, nullptr);
    close(stop_event);
}

}  // namespace stator
