"""The sound of a run: what its flow radiates, with the noise of the jet if asked, and as a WAV file."""
