"""Live output: the listeners' signals go to devices and loudspeakers while the timeline plays; any
other event stops them."""
