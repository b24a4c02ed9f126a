"""Limits of the page and of the processes that compute for it."""


class PAGE:
    """What a request may hold, what an answer holds, and how long workers may take."""

    # Largest modulus of a number from a client: its cube is still a number. Models know narrower
    # bounds
    number: float = 1e100
    # Maximum number of parameters or states of a request; a chain of fifty masses has hundreds
    names: int = 1000
    name_length: int = 200  # maximum number of characters of a name
    # Maximum number of characters of a model's text: twenty times the longest one of the package
    text: int = 64 * 1024
    pins: int = 12  # curves pinned beside a diagram: more cannot be distinguished
    bodies: int = 40  # maximum number of bodies of a mechanism that is drawn in a row
    texts: int = 16  # models made of texts that are stored: a page undoes a few steps at once
    margin: float = 1e-3  # distance of a slider from what the model does not allow, over the value
    starts: int = 8  # starts of further branches of a diagram: each takes as long as the response
    # Seconds of a processor for branches beyond those of the response, which are seen meanwhile
    filling: float = 5.0
    following: float = 20.0  # seconds of a processor for the branches of the response
    loci: float = 60.0  # seconds of a processor for a bifurcation set, drawn as it grows
    # Difference of an orbit's value from the requested one, in spans; rounding at folds makes less
    apart: float = 1e-3
    # Results stored: diagrams below a megabyte, trajectories of some megabytes at most
    kept: int = 16
    # Significant digits of what is drawn: a screen shows four, a zoom a hundredfold six
    digits: int = 7
    points: int = 20_000  # points that a browser draws and searches without delay
    interval: float = 0.1  # minimum time between two notes of progress, in s
    # Samples a forcing period for spectra and extrema; four times as many make smooth curves
    samples: int = 64
    max_samples: int = 4096  # maximum number of samples of one orbit
    orders: int = 8  # highest frequency shown, in forcing frequencies
    window: int = 256  # periods at most in which a simulation is shown: 16 samples each are left
    section: int = 2000  # points at most of a Poincare section: more cover each other
    # Extrema over time of a simulation: a column of pixels each on a wide screen
    columns: int = 1000
    least_samples: int = 8  # samples a period at least, where a column has many periods
    piece: int = 16  # columns sampled together, after which a cancelled request is dropped
    # Error of exponents at which a computation ends: more digits than the page shows
    exponent_tolerance: float = 1e-6
    workers: int = 4  # maximum number of processes by default
    # Maximum data memory of a worker in bytes: a larger request fails, not the machine
    data_bytes: int = 2 * 2**30
    warming: float = 5.0  # seconds after which the first diagram is not waited for
    # Later jobs that may go before one of the next rank, so that no job waits forever
    overtaken: int = 40
    # Seconds that a quick job waits for a worker before one more is started: that takes a second
    patience: float = 0.3
    # Seconds that a worker has to drop what has taken too long, before it is ended
    grace: float = 2.0
