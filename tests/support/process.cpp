#include "support/process.h"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include <fcntl.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace parhelion::testing {

namespace {

using Clock = std::chrono::steady_clock;

struct Pipe {
    int read_end = -1, write_end = -1;
    Pipe() {
        int ends[2];
        if (pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("pipe2");
        read_end = ends[0];
        write_end = ends[1];
    }
    ~Pipe() {
        if (read_end >= 0) close(read_end);
        if (write_end >= 0) close(write_end);
    }
    void close_write() {
        close(write_end);
        write_end = -1;
    }
};

// In the child, between fork and exec.
[[noreturn]] void become_program(const std::vector<std::string>& words, const ProcessOptions& options, const Pipe& out, const Pipe& err) {
    const int out_file =
        options.stdout_file.empty() ? out.write_end : open(options.stdout_file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    dup2(out_file, 1);
    dup2(err.write_end, 2);
    if (!options.folder.empty() && chdir(options.folder.c_str()) != 0) _exit(126);
    for (const auto& [name, value] : options.environment) setenv(name.c_str(), value.c_str(), 1);
    if (options.file_size_limit) {
        const rlimit limit{*options.file_size_limit, *options.file_size_limit};
        setrlimit(RLIMIT_FSIZE, &limit);
        std::signal(SIGXFSZ, SIG_IGN);
    }
    std::vector<char*> pointers;
    for (const std::string& word : words) pointers.push_back(const_cast<char*>(word.c_str()));
    pointers.push_back(nullptr);
    execvp(pointers[0], pointers.data());
    _exit(127);
}

// Reads what is there; false at the end of the stream.
bool drain(int file, std::string& text) {
    char buffer[4096];
    const ssize_t count = read(file, buffer, sizeof(buffer));
    if (count > 0) text.append(buffer, static_cast<size_t>(count));
    return count > 0 || (count < 0 && errno == EINTR);
}

class Watcher {
public:
    Watcher(pid_t process, const ProcessOptions& options) : process_(process), options_(options) {}
    void poll_signal(const ProcessResult& so_far) {
        const auto now = Clock::now();
        if (options_.signal == 0 || sent_ >= options_.signal_count) return;
        if (sent_ == 0 ? !options_.signal_when(so_far) : now - last_ < std::chrono::milliseconds(50)) return;
        if (sent_ == 0) first_ = now;
        last_ = now;
        kill(process_, options_.signal);
        ++sent_;
    }
    double seconds_since_signal() const { return sent_ == 0 ? 0 : std::chrono::duration<double>(Clock::now() - first_).count(); }

private:
    pid_t process_;
    const ProcessOptions& options_;
    int sent_ = 0;
    Clock::time_point first_, last_;
};

void collect(const Pipe& out, const Pipe& err, Watcher& watcher, ProcessResult& result) {
    bool out_open = true, err_open = true;
    while (out_open || err_open) {
        pollfd files[2] = {{out_open ? out.read_end : -1, POLLIN, 0}, {err_open ? err.read_end : -1, POLLIN, 0}};
        poll(files, 2, 10);
        if (files[0].revents != 0) out_open = drain(out.read_end, result.out);
        if (files[1].revents != 0) err_open = drain(err.read_end, result.err);
        watcher.poll_signal(result);
    }
}

}  // namespace

ProcessResult run_parhelion(const std::vector<std::string>& arguments, const ProcessOptions& options) {
    // The one that was built; in a bundle, which has its own, the one on the path.
    const std::string built = std::string(PARHELION_BINARY_DIR) + "/parhelion";
    std::vector<std::string> words{std::filesystem::exists(built) ? built : "parhelion"};
    words.insert(words.end(), arguments.begin(), arguments.end());
    Pipe out, err;
    const pid_t process = fork();
    if (process < 0) throw std::runtime_error("fork");
    if (process == 0) become_program(words, options, out, err);
    out.close_write();
    err.close_write();
    ProcessResult result;
    Watcher watcher(process, options);
    collect(out, err, watcher, result);
    int status = 0;
    while (waitpid(process, &status, 0) < 0 && errno == EINTR) {}
    result.seconds_after_signal = watcher.seconds_since_signal();
    if (WIFEXITED(status)) result.exit_code = WEXITSTATUS(status);
    if (WIFSIGNALED(status)) result.signal = WTERMSIG(status);
    return result;
}

TemporaryFolder::TemporaryFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "parhelion-test-XXXXXX").string();
    if (!mkdtemp(pattern.data())) throw std::runtime_error("mkdtemp");
    path_ = pattern;
}

TemporaryFolder::~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
}

std::vector<std::string> TemporaryFolder::names() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(path_)) names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
}

std::string read_bytes(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    std::stringstream bytes;
    bytes << stream.rdbuf();
    return bytes.str();
}

}  // namespace parhelion::testing
