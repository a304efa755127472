// A lock between threads of different levels: who waits lends its priority to the holder.
#pragma once

#include <pthread.h>

namespace stator {

class Mutex {
  public:
    Mutex();
    Mutex(const Mutex&) = delete;
    Mutex& operator=(const Mutex&) = delete;

    void lock() { pthread_mutex_lock(&mutex_); }
    void unlock() { pthread_mutex_unlock(&mutex_); }

  private:
    pthread_mutex_t mutex_;
};

// Holds a mutex until the end of its scope; none if there is none.
class Lock {
  public:
    explicit Lock(Mutex* mutex) : mutex_(mutex) {
        if (mutex_ != nullptr) mutex_->lock();
    }
    ~Lock() {
        if (mutex_ != nullptr) mutex_->unlock();
    }
    Lock(const Lock&) = delete;
    Lock& operator=(const Lock&) = delete;

  private:
    Mutex* mutex_;
};

}  // namespace stator
