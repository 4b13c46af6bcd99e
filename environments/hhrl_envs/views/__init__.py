"""The environments that users make: PettingZoo, Gymnasium and vector views of one simulator, their spaces and infos."""
