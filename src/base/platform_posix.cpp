#include "base/platform.h"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <string>

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/ioctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

namespace parhelion::platform {

namespace {

volatile std::sig_atomic_t g_interrupt = 0;

void on_signal(int number) {
    if (g_interrupt != 0) _exit(number == SIGTERM ? 143 : 130);
    g_interrupt = number;
}

uint64_t status_kilobytes(const std::string& key) {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);)
        if (line.rfind(key, 0) == 0) return std::strtoull(line.c_str() + key.size(), nullptr, 10);
    return 0;
}

}  // namespace

void install_interrupt_handlers() {
    struct sigaction action {};
    action.sa_handler = on_signal;
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
    std::signal(SIGPIPE, SIG_IGN);
}

Interrupt interrupt_requested() {
    const int number = g_interrupt;
    return number == 0 ? Interrupt::None : number == SIGTERM ? Interrupt::Terminated : Interrupt::Interrupted;
}

void set_interrupt(Interrupt value) { g_interrupt = value == Interrupt::None ? 0 : value == Interrupt::Terminated ? SIGTERM : SIGINT; }

bool is_terminal(int file_descriptor) { return isatty(file_descriptor) != 0; }

unsigned terminal_width() {
    winsize size{};
    return ioctl(2, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

uint64_t process_id() { return static_cast<uint64_t>(getpid()); }
bool process_exists(uint64_t process) { return kill(static_cast<pid_t>(process), 0) == 0 || errno == EPERM; }
uint64_t resident_bytes() { return status_kilobytes("VmRSS:") * 1024; }
uint64_t peak_resident_bytes() { return status_kilobytes("VmHWM:") * 1024; }

uint64_t physical_bytes() { return static_cast<uint64_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<uint64_t>(sysconf(_SC_PAGESIZE)); }

std::filesystem::path cache_folder() {
    if (const char* own = std::getenv("PARHELION_CACHE_DIR"); own && *own) return own;
    if (const char* xdg = std::getenv("XDG_CACHE_HOME"); xdg && *xdg) return std::filesystem::path(xdg) / "parhelion";
    if (const char* home = std::getenv("HOME"); home && *home) return std::filesystem::path(home) / ".cache" / "parhelion";
    return std::filesystem::temp_directory_path() / "parhelion-cache";
}

OpenedFile open_for_reading(const std::filesystem::path& path) {
    OpenedFile out;
    const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    if (descriptor < 0) return out;
    struct stat status {};
    if (fstat(descriptor, &status) == 0) {
        out.kind = S_ISREG(status.st_mode) ? FileKind::Regular : S_ISDIR(status.st_mode) ? FileKind::Folder : FileKind::Other;
        out.size = static_cast<uint64_t>(status.st_size);
        out.file = fdopen(descriptor, "rb");
    }
    if (out.file == nullptr) close(descriptor);
    return out;
}

bool sync_file(const std::filesystem::path& path) {
    const int file = open(path.c_str(), O_WRONLY | O_CLOEXEC);
    if (file < 0) return false;
    const bool synced = fsync(file) == 0 || errno == EINVAL || errno == EROFS;
    return close(file) == 0 && synced;
}

std::string become_program(const std::filesystem::path& program, const std::vector<std::string>& words) {
    std::vector<char*> arguments{const_cast<char*>(program.c_str())};
    for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    execv(program.c_str(), arguments.data());
    return std::strerror(errno);
}

std::filesystem::path program_folder() {
    std::error_code ignored;
    return std::filesystem::read_symlink("/proc/self/exe", ignored).parent_path();
}

CommandResult run_command(const std::string& line) {
    constexpr size_t kMostOutput = 1u << 16;
    CommandResult result;
    std::FILE* pipe = popen(("{ " + line + "\n} 2>&1").c_str(), "re");
    if (!pipe) return result;
    char buffer[4096];
    while (const size_t got = std::fread(buffer, 1, sizeof buffer, pipe)) result.output.append(buffer, std::min(got, kMostOutput - std::min(kMostOutput, result.output.size())));
    const int status = pclose(pipe);
    if (WIFEXITED(status)) result.exit_code = WEXITSTATUS(status);
    return result;
}

void* load_library(const std::string& name) { return dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL); }
void* library_symbol(void* library, const char* name) { return dlsym(library, name); }

}  // namespace parhelion::platform
