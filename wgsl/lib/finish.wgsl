// Drivers may leave loops silently. Every loop that matters checks behind itself that it came to its
// end; a kernel calls `finish` last. The kernel declares `params.flag` and the binding `status`.

var<private> unfinished: bool = false;

fn finish() {
    if unfinished {
        atomicMax(&status[params.flag], 1u);
    }
}
