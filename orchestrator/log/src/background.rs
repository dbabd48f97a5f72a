//! Threads that write while a run continues.

use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, sync_channel};
use std::thread::JoinHandle;
use std::time::Duration;

/// Largest number of items that wait for the thread; when the queue is full, the run waits.
const QUEUE: usize = 1024;
/// Interval at which the thread looks for items: waking it for each one would cost the run more than the exchange of a step.
const LOOK: Duration = Duration::from_millis(1);

/// How often what was written is to reach the disk.
pub const FLUSH_INTERVAL: Duration = Duration::from_secs(1);

/// A thread that does what it is sent, in that order; it ends, and is waited for, when this is dropped.
pub struct Background<T, E> {
    queue: Option<SyncSender<T>>,
    thread: Option<JoinHandle<Result<(), E>>>,
}

/// What the thread is sent: nothing if nothing came for a millisecond, and the end once no more can come.
pub struct Queue<T> {
    receiver: Receiver<T>,
    /// Whether the first item has come, which is awaited.
    begun: bool,
}

/// Why a thread ended before it was told to.
pub enum Stopped<E> {
    /// By an error.
    Failed(E),
    /// By a defect of the program.
    Panicked,
}

impl<T: Send + 'static, E: Send + 'static> Background<T, E> {
    /// Begins a thread that does this `work`.
    ///
    /// **Errors**: those of the system.
    pub fn begin(work: impl FnOnce(Queue<T>) -> Result<(), E> + Send + 'static) -> std::io::Result<Self> {
        let (sender, receiver) = sync_channel(QUEUE);
        let queue = Queue { receiver, begun: false };
        let thread = std::thread::Builder::new().spawn(move || work(queue))?;
        Ok(Self { queue: Some(sender), thread: Some(thread) })
    }

    /// Sends it an item; whether the thread still continues. If not, [`end`](Self::end) tells why.
    pub fn send(&mut self, item: T) -> bool {
        if self.queue.as_ref().is_some_and(|queue| queue.send(item).is_err()) {
            self.queue = None;
        }
        self.queue.is_some()
    }
}

impl<T, E> Background<T, E> {
    /// Waits until it has done all that it was sent.
    ///
    /// **Errors**: why it ended before.
    pub fn end(&mut self) -> Result<(), Stopped<E>> {
        self.queue = None;
        match self.thread.take().map(JoinHandle::join) {
            None | Some(Ok(Ok(()))) => Ok(()),
            Some(Ok(Err(error))) => Err(Stopped::Failed(error)),
            Some(Err(_)) => Err(Stopped::Panicked),
        }
    }
}

impl<T, E> Drop for Background<T, E> {
    fn drop(&mut self) {
        // Who wants to know why it ended has asked.
        let _ = self.end();
    }
}

impl<T> Iterator for Queue<T> {
    type Item = Option<T>;

    fn next(&mut self) -> Option<Self::Item> {
        if !self.begun {
            self.begun = true;
            return self.receiver.recv().ok().map(Some);
        }
        match self.receiver.try_recv() {
            Ok(item) => Some(Some(item)),
            Err(TryRecvError::Empty) => {
                std::thread::sleep(LOOK);
                Some(None)
            }
            Err(TryRecvError::Disconnected) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc::channel;

    #[test]
    fn everything_is_done_in_order_before_the_end_and_when_it_is_dropped() {
        for told in [true, false] {
            let (done, all) = channel();
            let work = move |queue: Queue<u32>| {
                queue.flatten().try_for_each(|item| {
                    std::thread::sleep(Duration::from_micros(10));
                    done.send(item)
                })
            };
            let mut background = Background::begin(work).expect("a thread");
            assert!((0..300).all(|item| background.send(item)));
            if told {
                assert!(background.end().is_ok() && background.end().is_ok());
                assert!(!background.send(300), "it has ended");
            }
            drop(background);
            assert!(all.try_iter().eq(0..300), "told: {told}");
        }
    }

    #[test]
    fn who_sends_is_told_that_it_ended_and_why() {
        let fails =
            |mut queue: Queue<u32>| queue.find_map(|item| item.filter(|item| *item == 3)).map_or(Ok(()), Err);
        let mut background = Background::begin(fails).expect("a thread");
        // More than the queue holds: it is not waited for what nobody takes.
        assert!(!(0..QUEUE as u32 + 10).all(|item| background.send(item)));
        assert!(matches!(background.end(), Err(Stopped::Failed(3))));
        let panics = |_: Queue<u32>| -> Result<(), ()> { std::panic::resume_unwind(Box::new(())) };
        let mut background = Background::begin(panics).expect("a thread");
        while background.send(0) {
            std::thread::yield_now();
        }
        assert!(matches!(background.end(), Err(Stopped::Panicked)));
    }
}
