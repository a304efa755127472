// The link of a graph that runs as threads: a Unix socket, served by the thread that waits for the
// end. docs/link.md lists requests and answers.
//
// That thread is no level and has no real-time priority, and it takes at most one event in
// kPause_us: a new client, or a few bytes of one. So whatever clients do costs the levels nothing,
// and the machine little.
#include "stator/link.hpp"

#include <fcntl.h>
#include <sys/epoll.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "internal.hpp"
#include "stator/answers.hpp"
#include "stator/observe.hpp"

namespace stator {

// Pins the sample as any reader does: the compiler plans a slot for it. Numbers do not go back.
bool copy_newest(const Topic& topic, uint8_t* to, size_t bytes, uint32_t& number) {
    const Pin& kept = topic.state->kept[current_level];
    Pin pin;
    if (!take_latest(topic, kept.is_kept ? kept.number : 0, pin)) return false;
    std::memcpy(to, sample_of(topic, pin), bytes);
    number = pin.number;
    release(topic, pin);
    return true;
}

namespace {

constexpr uint64_t kPause_us = 1000;  // of the machine's time: who asks lives in that
constexpr unsigned kMaxClients = 8;
constexpr int kMaxWaiting = 16;  // to be accepted
constexpr TickSource kNanosecondsOfCpu{1'000'000'000, 2, 1};

void put_sample(Writer& out, unsigned index) {
    const Topic& topic = *program.topics[index];
    const auto bytes = std::min(topic.sample_bytes, kMaxSampleBytes);
    std::array<uint8_t, kMaxSampleBytes> sample;
    uint32_t number = 0;
    const bool is_there = copy_newest(topic, sample.data(), bytes, number);
    out.put(static_cast<uint16_t>(index));
    out.put(number);
    if (is_there) out.put(sample.data(), bytes);
}

size_t answer(const uint8_t* request, size_t count, uint8_t* body) {
    Writer out(body);
    Asked asked;
    if (!begin_answer(request, count, out, asked)) return 0;
    switch (asked.kind) {
        case Request::kInfo:
            put_info(out, program, kNanosecondsOfCpu, clock_us());
            return out.count();
        case Request::kTasks:
            put_tasks(out, program, clock_us(), asked.argument, figures_of_task);
            return out.count();
        case Request::kSample:
            if (asked.argument >= program.topic_count) return 0;
            put_sample(out, asked.argument);
            return out.count();
        case Request::kParameter:
            return put_parameter(out, parameter_box, request, count) ? out.count() : 0;
        default:  // a process leaves no record of a fault
            return 0;
    }
}

// Somebody who asks. Nothing here waits for it.
class Client {
  public:
    Client(int descriptor, uint64_t now_us) : descriptor_(descriptor), served_us_(now_us) {}
    ~Client() { ::close(descriptor_); }
    Client(const Client&) = delete;
    Client& operator=(const Client&) = delete;

    int descriptor() const { return descriptor_; }
    uint64_t served_us() const { return served_us_; }

    // Takes a few bytes, and answers what they ask. False: the client has gone.
    bool serve(uint64_t now_us) {
        served_us_ = now_us;
        may_receive_ = true;
        link_.serve(*this);
        return !has_gone_;
    }
    // What to wait for: who does not read is not heard.
    uint32_t events() const { return link_.is_sending() ? EPOLLOUT : EPOLLIN; }

    // --- for the link ---

    size_t read(uint8_t* bytes, size_t most) {
        if (at_ == count_ && may_receive_) {
            may_receive_ = false;
            at_ = 0;
            count_ = moved(recv(descriptor_, received_.data(), received_.size(), 0));
        }
        const size_t count = std::min(most, count_ - at_);
        std::memcpy(bytes, received_.data() + at_, count);
        at_ += count;
        return count;
    }
    size_t write(const uint8_t* bytes, size_t count) {
        return moved(send(descriptor_, bytes, count, MSG_NOSIGNAL));
    }

  private:
    size_t moved(ssize_t count) {
        if (count > 0) return static_cast<size_t>(count);
        has_gone_ = has_gone_ || count == 0 || (errno != EAGAIN && errno != EINTR);
        return 0;
    }

    int descriptor_;
    uint64_t served_us_;
    Link link_{answer};
    std::array<uint8_t, 32> received_{};  // of a turn: two requests
    size_t at_ = 0;
    size_t count_ = 0;
    bool may_receive_ = false;
    bool has_gone_ = false;
};

// --- the socket ---

std::vector<std::unique_ptr<Client>> clients;
int listener = -1;
int events = -1;  // of all of them, an epoll
uint64_t next_turn_us = 0;
sockaddr_un address{};
struct stat bound {};  // the file at `address`: whether it still is this one

bool wait_for(int operation, int descriptor, uint32_t what) {
    epoll_event event{};
    event.events = what;
    event.data.fd = descriptor;
    return epoll_ctl(events, operation, descriptor, &event) == 0;
}

// Who was silent the longest makes room. With a descriptor, its place in the epoll goes.
void accept_client(uint64_t now_us) {
    const int descriptor = accept4(listener, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (descriptor < 0) return;
    auto client = std::make_unique<Client>(descriptor, now_us);
    if (!wait_for(EPOLL_CTL_ADD, descriptor, EPOLLIN)) return;
    if (clients.size() == kMaxClients) {
        clients.erase(std::min_element(
            clients.begin(), clients.end(),
            [](const auto& a, const auto& b) { return a->served_us() < b->served_us(); }));
    }
    clients.push_back(std::move(client));
}

void serve_client(int descriptor, uint64_t now_us) {
    const auto found = std::find_if(
        clients.begin(), clients.end(),
        [descriptor](const auto& client) { return client->descriptor() == descriptor; });
    Client& client = **found;
    const uint32_t before = client.events();
    if (!client.serve(now_us)) {
        clients.erase(found);
    } else if (client.events() != before) {
        wait_for(EPOLL_CTL_MOD, descriptor, client.events());
    }
}

// Held while a socket is made or removed, so that of two runs each sees what the other has done.
class FolderLock {
  public:
    explicit FolderLock(const std::string& path) {
        const size_t end = path.rfind('/');
        const std::string folder = end == std::string::npos ? "." : path.substr(0, end + 1);
        descriptor_ = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
        if (descriptor_ >= 0) flock(descriptor_, LOCK_EX);
    }
    ~FolderLock() {
        if (descriptor_ >= 0) ::close(descriptor_);
    }
    FolderLock(const FolderLock&) = delete;
    FolderLock& operator=(const FolderLock&) = delete;

  private:
    int descriptor_ = -1;
};

const sockaddr* plain_address() {
    return reinterpret_cast<const sockaddr*>(&address);
}

bool refuse(const char* path, const char* why) {
    std::fprintf(stderr,
                 "error: cannot make a link at '%s': %s\nhint: use another path: --link PATH\n",
                 path, why);
    return false;
}
bool refuse(const char* why) {
    return refuse(address.sun_path, why);
}

// A socket that a run left behind when it was killed: nobody listens.
bool is_stale() {
    struct stat file {};
    if (stat(address.sun_path, &file) != 0 || !S_ISSOCK(file.st_mode)) return false;
    const int probe = socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    const bool refused =
        connect(probe, plain_address(), sizeof address) != 0 && errno == ECONNREFUSED;
    ::close(probe);
    return refused;
}

bool make_socket() {
    events = epoll_create1(EPOLL_CLOEXEC);
    listener = socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (events < 0 || listener < 0) return refuse(std::strerror(errno));
    const FolderLock lock(address.sun_path);
    if (is_stale()) unlink(address.sun_path);
    if (bind(listener, plain_address(), sizeof address) != 0) {
        return refuse(errno == EADDRINUSE ? "it is another one's" : std::strerror(errno));
    }
    if (stat(address.sun_path, &bound) != 0 || listen(listener, kMaxWaiting) != 0) {
        return refuse(std::strerror(errno));
    }
    return true;
}

}  // namespace

bool offer_link(const char* path) {
    if (std::strlen(path) >= sizeof address.sun_path) {
        return refuse(path, "the path is too long for a socket");
    }
    address.sun_family = AF_UNIX;
    std::strcpy(address.sun_path, path);
    clients.reserve(kMaxClients);
    return make_socket() &&
           (wait_for(EPOLL_CTL_ADD, listener, EPOLLIN) || refuse(std::strerror(errno)));
}

int link_events(uint64_t now_us) {
    return now_us < next_turn_us ? -1 : events;
}

uint64_t next_link_turn_us(uint64_t now_us) {
    return events >= 0 && now_us < next_turn_us ? next_turn_us : UINT64_MAX;
}

void serve_link(uint64_t now_us) {
    epoll_event event{};
    if (epoll_wait(events, &event, 1, 0) != 1) return;
    next_turn_us = now_us + graph_us(kPause_us);
    if (event.data.fd == listener) {
        accept_client(now_us);
    } else {
        serve_client(event.data.fd, now_us);
    }
}

void close_link() {
    if (events < 0) return;
    const FolderLock lock(address.sun_path);
    struct stat file {};
    const bool is_own = stat(address.sun_path, &file) == 0 && file.st_ino == bound.st_ino &&
                        file.st_dev == bound.st_dev;
    if (is_own) unlink(address.sun_path);
    clients.clear();
    ::close(listener);
    ::close(events);
    events = -1;
}

}  // namespace stator
